#include "base/utf8.h"

#include <gtest/gtest.h>

#include <string>

namespace foreland {
namespace {

using namespace std::string_literals;

std::string utf8(const std::string& bytes) {
  std::string storage;
  const auto text = asUtf8(bytes, storage);
  return text.ok() ? std::string(*text) : "Error: " + text.error().message;
}

std::string utf16(const std::u16string& text, bool is_big) {
  std::string bytes;
  for (const char16_t unit : text) {
    const char high = static_cast<char>(unit >> 8), low = static_cast<char>(unit & 0xff);
    bytes += is_big ? high : low;
    bytes += is_big ? low : high;
  }
  return bytes;
}

TEST(Utf8, KeepsTextWithoutItsMark) {
  for (const std::string& text : {""s, "v 0 0 0\n"s, "H\xc3\xb6he"s, "H\xf6he"s, "solid\0\0\0\0"s}) {
    EXPECT_EQ(utf8(text), text);
    EXPECT_EQ(utf8("\xef\xbb\xbf" + text), text);
  }
}

TEST(Utf8, ConvertsBothOrdersOfUtf16) {
  const std::u16string text = u"v 0 1\r\nH\u00f6he \u4e2d \U0001f5fb";
  const std::string expected = "v 0 1\r\nH\xc3\xb6he \xe4\xb8\xad \xf0\x9f\x97\xbb";
  for (const bool is_big : {false, true}) {
    EXPECT_EQ(utf8(utf16(u'\ufeff' + text, is_big)), expected);
    EXPECT_EQ(utf8(utf16(u"v 0 0 0\nf 1 2 3\n", is_big)), "v 0 0 0\nf 1 2 3\n") << "without a mark";
    EXPECT_EQ(utf8(utf16(u'\ufeff' + text, is_big) + "x"), expected) << "with half a character at the end";
  }
}

TEST(Utf8, HalvesOfPairsAreReplaced) {
  for (const char16_t half : {u'\xd800', u'\xdbff', u'\xdc00', u'\xdfff'})
    for (const std::u16string& text : {u"\ufeffa"s + half, u"\ufeffa"s + half + u"b"})
      EXPECT_EQ(utf8(utf16(text, true)).substr(0, 4), "a\xef\xbf\xbd");
}

TEST(Utf8, RefusesUtf32) {
  EXPECT_EQ(utf8("\xff\xfe\0\0v\0\0\0"s), "Error: is text in UTF-32; save it as UTF-8");
  EXPECT_EQ(utf8("\0\0\xfe\xff\0\0\0v"s), "Error: is text in UTF-32; save it as UTF-8");
}

}  // namespace
}  // namespace foreland
