// Packing loses nothing of what is known of a page, and takes few bytes where nodes share their neighbours' fate.
#include "proto/refine/memory/page_knowledge.h"

#include <gtest/gtest.h>
#include <rapidcheck.h>
#include <rapidcheck/gtest.h>

namespace foreland::proto {
namespace {

// Runs of nodes that are all known or all unknown, and likewise of settled ones; a run may be a single node.
SlotBits runs(uint32_t longest) {
  SlotBits bits;
  bool is_set = *rc::gen::arbitrary<bool>();
  for (uint32_t at = 0; at < kPageSlots; is_set = !is_set)
    for (uint32_t left = *rc::gen::inRange(1u, longest + 1); left > 0 && at < kPageSlots; --left, ++at)
      bits.add(static_cast<uint8_t>(at), is_set);
  return bits;
}

PageKnowledge anyPage() {
  const uint32_t longest = *rc::gen::element(1u, 2u, 5u, 16u, 80u, 256u);
  PageKnowledge page;
  page.known = runs(longest);
  page.settled = page.known & runs(longest);
  page.radius.value = *rc::gen::arbitrary<uint8_t>();
  page.finest.value = *rc::gen::arbitrary<uint8_t>();
  return page;
}

Bytes packed(const PageKnowledge& page) {
  Bytes bytes;
  packPage(page, bytes);
  return bytes;
}

RC_GTEST_PROP(PageKnowledge, IsUnpackedAsItWasPackedWhateverFollows, ()) {
  const PageKnowledge page = anyPage();
  Bytes bytes = packed(page);
  RC_ASSERT(bytes.size() <= kMaxPackedBytes);
  RC_ASSERT(unpackPage(bytes) == page);
  bytes.resize(bytes.size() + 8, *rc::gen::arbitrary<uint8_t>());
  RC_ASSERT(unpackPage(bytes) == page);
}

TEST(PageKnowledge, OfUniformPagesTakesTwelveBytesAtMost) {
  PageKnowledge none, all;
  all.known = all.settled = SlotBits::below(kPageSlots);
  EXPECT_LE(packed(none).size(), 12u);
  EXPECT_LE(packed(all).size(), 12u);
  EXPECT_EQ(unpackPage(packed(all)), all);
}

TEST(PageKnowledge, OfAnyBitsTakesTheMostAtMost) {
  PageKnowledge page;
  for (uint32_t low = 0; low < kPageSlots; ++low)
    page.known.add(static_cast<uint8_t>(low), (low * low * 7 + low / 3) % 5 != 0 || low % 2 == 0);
  page.settled = page.known;
  EXPECT_LE(packed(page).size(), kMaxPackedBytes);
  EXPECT_EQ(unpackPage(packed(page)), page);
}

}  // namespace
}  // namespace foreland::proto
