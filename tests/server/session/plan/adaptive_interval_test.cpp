#include "server/session/plan/adaptive_interval.h"

#include <gtest/gtest.h>

#include "base/rng.h"
#include "tests/support/seed.h"

namespace foreland::server {
namespace {

Duration ms(int64_t n) { return Duration::milliseconds(n); }
constexpr proto::KeyframeInterval kBounds{Duration::milliseconds(100), Duration::milliseconds(700)};

TEST(AdaptiveInterval, IsTheShortestWhereItIsFixedOrNothingIsKnown) {
  AdaptiveInterval adaptive;
  EXPECT_EQ(adaptive.next(kBounds, ms(700)), ms(100));
  adaptive.observe(0, 1000, ms(100));
  EXPECT_EQ(adaptive.next({ms(200), {}}, ms(200)), ms(200));
  EXPECT_EQ(adaptive.next({ms(200), ms(200)}, ms(200)), ms(200));
  adaptive.restart();
  EXPECT_EQ(adaptive.next(kBounds, ms(700)), ms(100));
}

TEST(AdaptiveInterval, IsWithinItsBoundsOnTheGridAndLengthensByOneStep) {
  const uint64_t seed = testing::UnitTest::GetInstance()->random_seed();
  SCOPED_TRACE("seed " + std::to_string(seed));
  Rng rng(seed);
  AdaptiveInterval adaptive;
  Duration last = ms(100);
  bool has_reached_both = false, has_reached_most = false;
  for (int i = 0; i < 5000; ++i) {
    const size_t most = i / 500 % 2 == 0 ? 30 : 3000;  // calm and fast spans in turn
    adaptive.observe(rng.below(most), rng.below(20) == 0 ? 0 : 1000, last);
    const Duration next = adaptive.next(kBounds, last);
    ASSERT_GE(next, ms(100));
    ASSERT_LE(next, ms(700));
    ASSERT_EQ(next.us % 100'000, 0);
    ASSERT_LE(next, last + ms(100));
    has_reached_most = has_reached_most || next == ms(700);
    has_reached_both = has_reached_both || (has_reached_most && next == ms(100));
    last = next;
  }
  EXPECT_TRUE(has_reached_both);
}

TEST(AdaptiveInterval, IsNoLongerTheMoreChanges) {
  Duration before = ms(700);
  for (size_t changed = 0; changed <= 1000; changed += 10) {
    AdaptiveInterval adaptive;
    adaptive.observe(changed, 1000, ms(200));
    const Duration next = adaptive.next(kBounds, ms(700));
    EXPECT_LE(next, before) << changed;
    before = next;
  }
  EXPECT_EQ(before, ms(100));
}

TEST(AdaptiveInterval, ShortensAtOnceAndStaysShortForAWhile) {
  AdaptiveInterval adaptive;
  for (int i = 0; i < 20; ++i) adaptive.observe(1, 1000, ms(700));
  EXPECT_EQ(adaptive.next(kBounds, ms(700)), ms(700));
  adaptive.observe(900, 1000, ms(700));
  EXPECT_EQ(adaptive.next(kBounds, ms(700)), ms(100));
  adaptive.observe(1, 1000, ms(100));
  EXPECT_LT(adaptive.next(kBounds, ms(700)), ms(700));
}

// By the next longer one on the grid, of which the region needs more than there is.
TEST(AdaptiveInterval, IsShortenedNoFurtherThanItsRegionNeeds) {
  Rng rng(test::randomSeed());
  int between = 0;
  for (int i = 0; i < 5000; ++i) {
    const Duration interval = ms(100) * static_cast<int64_t>(1 + rng.below(7));
    const double share = rng.uniform();
    const Duration shorter = AdaptiveInterval::shortened(kBounds, interval, share);
    ASSERT_GE(shorter, ms(100));
    ASSERT_LE(shorter, interval);
    ASSERT_EQ(shorter.us % 100'000, 0);
    const auto needs = [&](Duration t) { return t.toSeconds() / interval.toSeconds(); };
    if (shorter > ms(100)) { ASSERT_LE(needs(shorter), share * (1 + 1e-12)); }
    ASSERT_GT(needs(shorter + ms(100)), share * (1 - 1e-12));
    between += shorter > ms(100) && shorter < interval;
  }
  EXPECT_GT(between, 500);
  EXPECT_EQ(AdaptiveInterval::shortened(kBounds, ms(700), 1), ms(700));
  EXPECT_EQ(AdaptiveInterval::shortened({ms(200), {}}, ms(200), 0.1), ms(200)) << "fixed";
}

}  // namespace
}  // namespace foreland::server
