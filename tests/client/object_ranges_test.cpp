// Ranges never overlap, hold what was asked for, and are taken again once they are free.
#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "base/rng.h"
#include "client/object_patches.h"
#include "tests/support/seed.h"

namespace foreland::client {
namespace {

TEST(ObjectRanges, AreDisjointAndTakenAgain) {
  Rng rng(test::randomSeed());
  Ranges ranges;
  struct Taken {
    Range range;
    uint32_t asked;
  };
  std::vector<Taken> taken;
  std::vector<bool> is_taken;
  uint32_t asked = 0, max_asked = 0;
  for (int i = 0; i < 4000; ++i) {
    if (taken.empty() || rng.below(100) < (i % 1000 < 500 ? 60u : 40u)) {
      const auto size = static_cast<uint32_t>(rng.below(2000));
      const Range range = ranges.take(size);
      ASSERT_GE(range.end - range.begin, size);
      ASSERT_LE(range.end - range.begin, std::max(32u, size + size / 2));
      ASSERT_LE(range.end, ranges.count());
      is_taken.resize(ranges.count());
      for (uint32_t at = range.begin; at < range.end; ++at) {
        ASSERT_FALSE(is_taken[at]);
        is_taken[at] = true;
      }
      taken.push_back({range, size});
      max_asked = std::max(max_asked, asked += size);
    } else {
      const size_t which = rng.below(taken.size());
      ranges.free(taken[which].range);
      for (uint32_t at = taken[which].range.begin; at < taken[which].range.end; ++at) is_taken[at] = false;
      asked -= taken[which].asked;
      taken[which] = taken.back();
      taken.pop_back();
    }
    ASSERT_EQ(ranges.taken(), static_cast<uint32_t>(std::count(is_taken.begin(), is_taken.end(), true)));
  }
  EXPECT_LT(ranges.count(), 3 * max_asked);
}

}  // namespace
}  // namespace foreland::client
