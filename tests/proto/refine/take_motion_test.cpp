// The vector instructions against one entry at a time.
#include "proto/refine/take_motion.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "base/rng.h"
#include "tests/support/seed.h"

namespace foreland::proto {
namespace {

// A page's entries, as EntryPool keeps them: in whole vectors.
struct Entries {
  std::vector<uint32_t> slacks, bits;
  uint32_t count;

  Entries(Rng& rng, uint32_t n) : count(n) {
    const size_t held = (n + EntryPool::kVector - 1) / EntryPool::kVector * EntryPool::kVector;
    for (uint32_t i = 0; i < held; ++i) {
      const auto distance = static_cast<float>(std::exp2(rng.uniform(-4, 28)));
      const auto constraint = MotionConstraint::of(static_cast<uint32_t>(rng.below(4)), distance);
      const float slack = i < n ? static_cast<float>(std::exp2(rng.uniform(-10, 6))) : EntryPool::kEndless;
      const auto entry = FrontierEntry::of(static_cast<uint8_t>(rng.next()), QuantisedError{99}, constraint, slack);
      bits.push_back(entry.bits);
      slacks.push_back(entry.rest);
    }
    if (n > 0) slacks[rng.below(n)] = 0;
  }
};

TEST(TakeMotion, GivesTheSameBitsByVectors) {
  const uint64_t seed = test::randomSeed();
  Rng rng(seed);
  bool any_stale = false, any_kept = false;
  for (int round = 0; round < 500; ++round) {
    MotionBound motion;
    for (size_t g = 0; g < MotionBound::kSensitivities; ++g) motion.set(g, rng.uniform(0, 2), rng.uniform(0, 1e-3));
    Entries some(rng, static_cast<uint32_t>(rng.below(257)));
    std::vector<uint32_t> expected_slacks = some.slacks;
    const SlotBits expected = takeMotionByScalars(motion, expected_slacks.data(), some.bits.data(), some.count);
    for (const Vectors vectors : kAllVectors) {
      if (vectors > widestVectors()) break;
      std::vector<uint32_t> slacks = some.slacks;
      const SlotBits stale = takeMotion(motion, slacks.data(), some.bits.data(), some.count, vectors);
      ASSERT_EQ(stale, expected) << "seed " << seed;
      ASSERT_EQ(slacks, expected_slacks) << "seed " << seed;
    }
    any_stale = any_stale || expected.any();
    any_kept = any_kept || expected.count() < some.count;
  }
  EXPECT_TRUE(any_stale && any_kept);
}

}  // namespace
}  // namespace foreland::proto
