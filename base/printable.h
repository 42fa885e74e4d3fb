// Text from outside made fit for a log, an error message or a close reason: it cannot forge a line, hide what follows,
// or be invalid UTF-8. Pure; any thread.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

namespace foreland {

namespace printable_detail {

struct Character {
  uint32_t code = 0;
  size_t bytes = 0;  // 0: no valid character begins here
};

// By the table of well-formed sequences (Unicode 15, table 3-7).
inline Character characterAt(std::string_view text) {
  const auto byte = [&](size_t i) { return static_cast<uint8_t>(text[i]); };
  const uint8_t first = byte(0);
  if (first < 0x80) return {first, 1};
  const size_t size = first >= 0xf0 ? 4 : first >= 0xe0 ? 3 : 2;
  if (first < 0xc2 || first > 0xf4 || text.size() < size) return {};
  uint32_t code = first & (0x7fu >> size);
  for (size_t i = 1; i < size; ++i) {
    if ((byte(i) & 0xc0) != 0x80) return {};
    code = code << 6 | (byte(i) & 0x3fu);
  }
  const bool is_surrogate = code >= 0xd800 && code < 0xe000;
  const uint32_t least = size == 4 ? 0x10000 : size == 3 ? 0x800 : 0x80;
  if (code < least || code > 0x10ffff || is_surrogate) return {};
  return {code, size};
}

inline bool isControl(uint32_t code) {
  return code < 0x20 || (code >= 0x7f && code < 0xa0) || (code >= 0x200b && code <= 0x200f) ||
         (code >= 0x2028 && code <= 0x202e) || (code >= 0x2060 && code <= 0x206f) || code == 0xfeff;
}

inline std::string hexadecimal(uint32_t value, size_t min_digits) {
  std::string digits;
  for (; value > 0 || digits.size() < min_digits; value >>= 4)
    digits.insert(digits.begin(), "0123456789abcdef"[value & 15]);
  return digits;
}

}  // namespace printable_detail

// Whether all of it is well-formed.
inline bool isUtf8(std::string_view text) {
  while (!text.empty()) {
    const size_t bytes = printable_detail::characterAt(text).bytes;
    if (bytes == 0) return false;
    text.remove_prefix(bytes);
  }
  return true;
}

// The longest beginning of `text` that has at most `max_bytes` and does not end within a character of UTF-8.
inline std::string_view cutText(std::string_view text, size_t max_bytes) {
  if (text.size() <= max_bytes) return text;
  size_t end = max_bytes;
  while (end > 0 && (static_cast<uint8_t>(text[end]) & 0xc0) == 0x80) --end;
  return text.substr(0, end);
}

// `text` with every byte that is no valid UTF-8, and every control character (line ends, escapes, those that change the
// direction of writing), written as \xNN or \u{NNNN}; at most `max_bytes` of it, and "..." for what was cut.
inline std::string printable(std::string_view text, size_t max_bytes = 80) {
  using namespace printable_detail;
  std::string out;
  while (!text.empty()) {
    const Character c = characterAt(text);
    std::string next;
    if (c.bytes == 0)
      next = "\\x" + hexadecimal(static_cast<uint8_t>(text[0]), 2);
    else if (isControl(c.code))
      next = "\\u{" + hexadecimal(c.code, 1) + "}";
    else
      next = text.substr(0, c.bytes);
    if (out.size() + next.size() > max_bytes) return out + "...";
    out += next;
    text.remove_prefix(c.bytes == 0 ? 1 : c.bytes);
  }
  return out;
}

}  // namespace foreland
