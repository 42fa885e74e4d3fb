// Sets of slots against std::set.
#include "proto/refine/memory/slot_bits.h"

#include <gtest/gtest.h>

#include <set>
#include <vector>

#include "base/rng.h"

namespace foreland::proto {
namespace {

TEST(SlotBits, AreASetOfSlots) {
  const uint64_t seed = testing::UnitTest::GetInstance()->random_seed();
  Rng rng(seed);
  SlotBits bits, others;
  std::set<int> expected, other;
  for (int i = 0; i < 3000; ++i) {
    const uint8_t low = static_cast<uint8_t>(rng.next()), at = static_cast<uint8_t>(rng.next());
    if (rng.below(2))
      bits.set(low), expected.insert(low);
    else
      bits.clear(low), expected.erase(low);
    others.set(at), other.insert(at);
    ASSERT_EQ(bits.any(), !expected.empty());
    ASSERT_EQ(bits.count(), expected.size());
    ASSERT_EQ(bits.has(at), expected.contains(at)) << "seed " << seed;
    ASSERT_EQ(bits.countBefore(at), std::distance(expected.begin(), expected.lower_bound(at))) << "seed " << seed;
    std::vector<int> seen;
    bits.forEach([&](uint8_t slot) { seen.push_back(slot); });
    ASSERT_EQ(seen, std::vector<int>(expected.begin(), expected.end()));
    std::vector<int> descending, ranks;
    bits.forEachDescending([&](uint8_t slot) { descending.push_back(slot); });
    ASSERT_EQ(descending, std::vector<int>(expected.rbegin(), expected.rend()));
    bits.forEachRanked(others, [&](uint8_t slot, uint32_t rank) {
      ranks.push_back(slot);
      ASSERT_EQ(rank, others.countBefore(slot)) << "seed " << seed;
    });
    ASSERT_EQ(ranks, seen);
    const SlotBits both = bits & others, rest = bits - others, all = bits | others;
    ASSERT_EQ(both.has(low), expected.contains(low) && other.contains(low));
    ASSERT_EQ(rest.has(low), expected.contains(low) && !other.contains(low));
    ASSERT_EQ(all.has(low), expected.contains(low) || other.contains(low));
    if (i % 300 == 0) others = {}, other.clear();
  }
}

TEST(SlotBits, HoldThoseBelowAnEnd) {
  for (uint32_t end = 0; end <= 256; ++end) {
    const SlotBits below = SlotBits::below(end);
    for (uint32_t low = 0; low < 256; ++low) ASSERT_EQ(below.has(static_cast<uint8_t>(low)), low < end);
  }
}

}  // namespace
}  // namespace foreland::proto
