// What the readers of GPX and KML share of XML: names, and lines for messages. The tracks' readers alone use pugixml.
#pragma once

#include <algorithm>
#include <cstddef>
#include <pugixml.hpp>
#include <string>
#include <string_view>

#include "base/result.h"

namespace foreland::client {

// An element's name without its namespace prefix.
inline std::string_view localName(const pugi::xml_node& node) {
  const std::string_view name = node.name();
  const size_t colon = name.find(':');
  return colon == std::string_view::npos ? name : name.substr(colon + 1);
}

// The name of a document's outermost element.
inline std::string rootName(const pugi::xml_document& document) {
  return std::string(localName(document.document_element()));
}

// The line that an offset is on. Offsets ascend from call to call, so all calls together read the text once.
class LineCounter {
 public:
  explicit LineCounter(std::string_view text) : text_(text) {}
  size_t at(ptrdiff_t offset) {
    const size_t end = std::clamp<size_t>(offset < 0 ? 0 : static_cast<size_t>(offset), at_, text_.size());
    for (; at_ < end; ++at_) {
      const bool ends_with_lf = at_ + 1 < text_.size() && text_[at_ + 1] == '\n';
      if (text_[at_] == '\n' || (text_[at_] == '\r' && !ends_with_lf)) ++line_;
    }
    return line_;
  }

 private:
  std::string_view text_;
  size_t at_ = 0, line_ = 1;
};

// An Error that names the line where the text is no well-formed XML.
inline Status loadXml(std::string_view text, const std::string& name, pugi::xml_document& document) {
  if (const auto parsed = document.load_buffer(text.data(), text.size()); !parsed)
    return Error{ErrorCode::kMalformed, name + ":" + std::to_string(LineCounter(text).at(parsed.offset)) +
                                            ": is no well-formed XML: " + parsed.description()};
  return {};
}

}  // namespace foreland::client
