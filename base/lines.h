// Text cut into lines, without copying. A line ends with LF, CR LF or CR alone, as on the systems of the past and the
// present; a file may mix them. Value type; one owner; portable to WebAssembly.
#pragma once

#include <cstdint>
#include <string_view>

namespace foreland {

class Lines {
 public:
  explicit Lines(std::string_view text) : rest_(text) {}

  // The next line, without its end. False at the end of the text.
  bool next(std::string_view& line) {
    if (rest_.empty()) return false;
    const size_t end = rest_.find_first_of("\r\n");
    line = rest_.substr(0, end);
    rest_.remove_prefix(end == std::string_view::npos ? rest_.size() : end);
    const size_t end_bytes = rest_.starts_with("\r\n") ? 2 : 1;
    rest_.remove_prefix(rest_.empty() ? 0 : end_bytes);
    ++number_;
    return true;
  }
  uint64_t number() const { return number_; }  // of the line last given, from 1
  std::string_view rest() const { return rest_; }

 private:
  std::string_view rest_;
  uint64_t number_ = 0;
};

}  // namespace foreland
