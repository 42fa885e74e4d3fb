// Text files as programs save them: UTF-8 with or without a byte-order mark, and UTF-16 of either byte order. Readers
// of text formats call asUtf8 first, so that they see UTF-8 without a mark. Pure; any thread; portable to WebAssembly.
#pragma once

#include <algorithm>
#include <cstdint>
#include <string>
#include <string_view>

#include "base/result.h"

namespace foreland {

enum class TextEncoding : uint8_t { kUtf8, kUtf16Little, kUtf16Big, kUtf32 };

namespace utf8_detail {

inline constexpr size_t kJudgedBytes = 64;  // of a text without a mark

// Text of ASCII characters has a zero in every second byte as UTF-16, and none as UTF-8.
inline TextEncoding guessEncoding(std::string_view bytes) {
  const std::string_view begin = bytes.substr(0, std::min(bytes.size(), kJudgedBytes) / 2 * 2);
  bool first_are_zero = begin.size() >= 4, second_are_zero = first_are_zero, is_any_both = false;
  for (size_t i = 0; i + 1 < begin.size(); i += 2) {
    first_are_zero &= begin[i] == 0, second_are_zero &= begin[i + 1] == 0;
    is_any_both |= begin[i] == 0 && begin[i + 1] == 0;
  }
  if (is_any_both || first_are_zero == second_are_zero) return TextEncoding::kUtf8;
  return second_are_zero ? TextEncoding::kUtf16Little : TextEncoding::kUtf16Big;
}

inline TextEncoding encodingOf(std::string_view bytes) {
  using namespace std::string_view_literals;
  if (bytes.starts_with("\xff\xfe\0\0"sv) || bytes.starts_with("\0\0\xfe\xff"sv)) return TextEncoding::kUtf32;
  if (bytes.starts_with("\xff\xfe"sv)) return TextEncoding::kUtf16Little;
  if (bytes.starts_with("\xfe\xff"sv)) return TextEncoding::kUtf16Big;
  return guessEncoding(bytes);
}

inline void appendUtf8(uint32_t code, std::string& text) {
  const auto put = [&](uint32_t byte) { text += static_cast<char>(byte); };
  if (code < 0x80) return put(code);
  if (code < 0x800) return put(0xc0 | code >> 6), put(0x80 | (code & 0x3f));
  if (code < 0x10000) {
    put(0xe0 | code >> 12);
  } else {
    put(0xf0 | code >> 18);
    put(0x80 | (code >> 12 & 0x3f));
  }
  put(0x80 | (code >> 6 & 0x3f)), put(0x80 | (code & 0x3f));
}

// An odd byte at the end is dropped; half of a surrogate pair becomes U+FFFD.
inline std::string fromUtf16(std::string_view bytes, TextEncoding encoding) {
  constexpr uint32_t kReplacement = 0xfffd;
  const size_t high = encoding == TextEncoding::kUtf16Little ? 1 : 0;
  const auto unit = [&](size_t at) {
    return uint32_t{static_cast<uint8_t>(bytes[at + high])} << 8 | static_cast<uint8_t>(bytes[at + 1 - high]);
  };
  std::string text;
  text.reserve(bytes.size() / 2);
  for (size_t at = 0; at + 1 < bytes.size(); at += 2) {
    uint32_t code = unit(at);
    if (code >= 0xd800 && code < 0xe000) {
      const uint32_t next = code < 0xdc00 && at + 3 < bytes.size() ? unit(at + 2) : 0;
      const bool is_pair = next >= 0xdc00 && next < 0xe000;
      code = is_pair ? 0x10000 + ((code - 0xd800) << 10) + (next - 0xdc00) : kReplacement;
      if (is_pair) at += 2;
    }
    appendUtf8(code, text);
  }
  return text;
}

}  // namespace utf8_detail

// The text without its mark: within `bytes` if that is UTF-8 or has another encoding of one byte a character, else
// within `storage`, which is overwritten. Error, without a file's name: UTF-32.
[[nodiscard]] inline Result<std::string_view> asUtf8(std::string_view bytes, std::string& storage) {
  constexpr std::string_view kMark = "\xef\xbb\xbf";
  const TextEncoding encoding = utf8_detail::encodingOf(bytes);
  if (encoding == TextEncoding::kUtf32) return Error{ErrorCode::kUnsupported, "is text in UTF-32; save it as UTF-8"};
  std::string_view text = bytes;
  if (encoding != TextEncoding::kUtf8) text = storage = utf8_detail::fromUtf16(bytes, encoding);
  if (text.starts_with(kMark)) text.remove_prefix(kMark.size());
  return text;
}

}  // namespace foreland
