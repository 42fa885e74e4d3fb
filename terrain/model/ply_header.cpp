#include "terrain/model/ply_header.h"

#include <algorithm>
#include <array>
#include <optional>
#include <utility>

#include "base/lines.h"
#include "terrain/model/words.h"

namespace foreland::terrain {

namespace {

constexpr size_t kMaxElements = 64;     // a bound for what a header may ask
constexpr size_t kMaxProperties = 256;  // of one element
constexpr size_t kMaxTextures = 4096;

constexpr std::array<std::pair<std::string_view, PlyType>, 16> kTypes{{
    {"char", PlyType::kInt8},
    {"int8", PlyType::kInt8},
    {"uchar", PlyType::kUint8},
    {"uint8", PlyType::kUint8},
    {"short", PlyType::kInt16},
    {"int16", PlyType::kInt16},
    {"ushort", PlyType::kUint16},
    {"uint16", PlyType::kUint16},
    {"int", PlyType::kInt32},
    {"int32", PlyType::kInt32},
    {"uint", PlyType::kUint32},
    {"uint32", PlyType::kUint32},
    {"float", PlyType::kFloat},
    {"float32", PlyType::kFloat},
    {"double", PlyType::kDouble},
    {"float64", PlyType::kDouble},
}};

std::optional<PlyType> typeOf(std::string_view name) {
  for (const auto& [known, type] : kTypes)
    if (known == name) return type;
  return std::nullopt;
}

Error malformed(uint64_t line, const std::string& what) {
  return {ErrorCode::kMalformed, "line " + std::to_string(line) + " of its header " + what + "; export it again"};
}

Status addProperty(Words words, uint64_t line, PlyHeader& header) {
  if (header.elements.empty()) return malformed(line, "has a property before any element");
  auto& properties = header.elements.back().properties;
  if (properties.size() == kMaxProperties) return malformed(line, "has more than 256 properties");
  PlyProperty property;
  std::string_view type = words.next();
  if (type == "list") {
    const auto count_type = typeOf(words.next());
    if (!count_type || *count_type >= PlyType::kFloat) return malformed(line, "has a list without a count");
    property.is_list = true;
    property.count_type = *count_type;
    type = words.next();
  }
  const auto known = typeOf(type);
  if (!known) return malformed(line, "has the unknown type '" + std::string(type.substr(0, 40)) + "'");
  property.type = *known;
  property.name = words.next();
  properties.push_back(std::move(property));
  return {};
}

Status addElement(Words words, uint64_t line, PlyHeader& header) {
  if (header.elements.size() == kMaxElements) return malformed(line, "has more than 64 elements");
  const std::string_view name = words.next();
  const auto count = parseNumber<uint64_t>(words.next());
  if (name.empty() || !count) return malformed(line, "has an element without a count");
  header.elements.push_back({std::string(name), *count, {}});
  return {};
}

Status setForm(Words words, uint64_t line, PlyHeader& header) {
  const std::string_view form = words.next();
  if (form == "ascii")
    header.form = PlyForm::kAscii;
  else if (form == "binary_little_endian")
    header.form = PlyForm::kLittleEndian;
  else if (form == "binary_big_endian")
    header.form = PlyForm::kBigEndian;
  else
    return malformed(line, "has the unknown format '" + std::string(form.substr(0, 40)) + "'");
  return {};
}

}  // namespace

size_t plyTypeBytes(PlyType type) {
  constexpr std::array<size_t, 8> kBytes{1, 1, 2, 2, 4, 4, 4, 8};
  return kBytes[static_cast<size_t>(type)];
}

Result<PlyHeader> parsePlyHeader(std::string_view text) {
  PlyHeader header;
  Lines lines(text);
  std::string_view line;
  if (!lines.next(line) || Words(line).rest() != "ply")
    return Error{ErrorCode::kMalformed, "not a PLY file; name an .obj or .ply model"};
  while (lines.next(line)) {
    Words words(line);
    const std::string_view key = words.next();
    Status status;
    if (key == "format") status = setForm(words, lines.number(), header);
    if (key == "element") status = addElement(words, lines.number(), header);
    if (key == "property") status = addProperty(words, lines.number(), header);
    if (key == "comment" && words.next() == "TextureFile" && header.textures.size() < kMaxTextures)
      header.textures.emplace_back(words.rest());
    if (!status.ok()) return status.error();
    if (key == "end_header") {
      // Where lines end with CR alone, an LF behind the last of them is data.
      const bool ends_with_cr = text.find('\n') == std::string_view::npos || text.find('\r') + 1 < text.find('\n');
      const size_t end = static_cast<size_t>(line.data() - text.data()) + line.size();
      header.bytes = ends_with_cr ? std::min(end + 1, text.size()) : text.size() - lines.rest().size();
      return header;
    }
  }
  return Error{ErrorCode::kMalformed, "its header has no end; export it again"};
}

}  // namespace foreland::terrain
