// Vectors of the draft (draft-eastlake-fnv, FNV-1a, 64 bits).
#include "base/fnv1a.h"

#include <gtest/gtest.h>

namespace foreland {
namespace {

uint64_t hashOf(std::string_view text) {
  Fnv1a hash;
  hash.add(text);
  return hash.value();
}

TEST(Fnv1aTest, HasThePublishedValues) {
  EXPECT_EQ(hashOf(""), 0xcbf29ce484222325u);
  EXPECT_EQ(hashOf("a"), 0xaf63dc4c8601ec8cu);
  EXPECT_EQ(hashOf("foobar"), 0x85944171f73967e8u);
}

TEST(Fnv1aTest, TakesAWordAsItsBytes) {
  Fnv1a word;
  word.addWord(0x61'6263'6465'6667ull);
  EXPECT_EQ(word.value(), hashOf(std::string_view("gfedcba\0", 8)));
}

}  // namespace
}  // namespace foreland
