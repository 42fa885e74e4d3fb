// Text from outside: whatever comes in, what comes out is valid UTF-8 on one line, and plain text stays as it is.
#include "base/printable.h"

#include <gtest/gtest.h>

#include "base/rng.h"
#include "tests/support/seed.h"

namespace foreland {
namespace {

bool isPlain(const std::string& text) {
  for (size_t i = 0; i < text.size();) {
    const printable_detail::Character c = printable_detail::characterAt(std::string_view(text).substr(i));
    if (c.bytes == 0 || printable_detail::isControl(c.code)) return false;
    i += c.bytes;
  }
  return true;
}

TEST(Printable, MakesAnyBytesOneLineOfUtf8) {
  const uint64_t seed = test::seedOr(1);
  SCOPED_TRACE("seed " + std::to_string(seed));
  Rng rng(seed);
  for (int round = 0; round < 20'000; ++round) {
    std::string text(rng.below(30), '\0');
    // Mostly beginnings and continuations of characters.
    for (char& c : text) c = static_cast<char>(rng.below(2) == 0 ? rng.below(256) : 0x80 + rng.below(0x7f));
    const size_t most = rng.below(40);
    const std::string out = printable(text, most);
    ASSERT_TRUE(isPlain(out)) << round;
    ASSERT_LE(out.size(), most + 3);
  }
}

TEST(Printable, LeavesPlainTextAsItIs) {
  for (const char* text : {"", "survey", "Zürich \xe2\x80\x93 \xf0\x9f\x8f\x94", "a'b\"c\\d"})
    EXPECT_EQ(printable(text), text);
}

TEST(Printable, ShowsWhatWouldForgeALineOrHideText) {
  EXPECT_EQ(printable("a\n12:00:00 info all is well"), "a\\u{a}12:00:00 info all is well");
  EXPECT_EQ(printable("\x1b[2J\x7f"), "\\u{1b}[2J\\u{7f}");
  EXPECT_EQ(printable("\xe2\x80\xae"
                      "abc"),
            "\\u{202e}abc");
  EXPECT_EQ(printable("\xc0\xaf\xed\xa0\x80\xf5"), "\\xc0\\xaf\\xed\\xa0\\x80\\xf5");
}

TEST(CutText, EndsOnACharacter) {
  EXPECT_EQ(cutText("a\xc3\xbc"
                    "b",
                    2),
            "a");
  EXPECT_EQ(cutText("a\xc3\xbc"
                    "b",
                    3),
            "a\xc3\xbc");
  EXPECT_EQ(cutText("abc", 10), "abc");
}

}  // namespace
}  // namespace foreland
