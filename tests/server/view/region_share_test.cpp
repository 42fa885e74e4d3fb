#include "server/view/region_share.h"

#include <gtest/gtest.h>

#include <cmath>
#include <set>
#include <utility>
#include <vector>

#include "base/rng.h"
#include "tests/support/seed.h"

namespace foreland::server {
namespace {

constexpr Region kMotion{40, 0.2}, kError{100, 0.6};

TEST(RegionShare, IsTheWholeRegionWhereItAddsLittle) {
  RegionShare share;
  for (int i = 0; i < 100; ++i)
    if (share.isDue(130'000)) share.observe(share.of(kMotion, kError), 130'000, 100'000);
  EXPECT_EQ(share.share(), 1);
  EXPECT_DOUBLE_EQ(share.of(kMotion, kError).radius_m, kMotion.radius_m + kError.radius_m);
  EXPECT_DOUBLE_EQ(share.of(kMotion, kError).angle_rad, kMotion.angle_rad + kError.angle_rad);
}

// The keyframes between observations of a section of a steady size.
std::vector<uint32_t> intervalsOf(size_t nodes, size_t pose_alone) {
  RegionShare share;
  std::vector<uint32_t> intervals;
  uint32_t since = 0;
  for (int i = 0; i < 1000; ++i) {
    ++since;
    if (!share.isDue(nodes)) continue;
    share.observe(share.of(kMotion, kError), nodes, pose_alone);
    intervals.push_back(std::exchange(since, 0));
  }
  EXPECT_EQ(intervals.front(), 1u);
  intervals.erase(intervals.begin());
  return intervals;
}

TEST(RegionShare, IsObservedSeldomWhileSectionsStayAsLarge) {
  for (const auto& [pose_alone, most] : {std::pair{100'000u, RegionShare::kSeldom}, {80'000u, RegionShare::kOften}})
    for (const uint32_t interval : intervalsOf(110'000, pose_alone)) {
      EXPECT_LE(interval, most);
      EXPECT_GT(interval, most / 2);
    }
}

// Else viewers who came together would make a server late all at once.
TEST(RegionShare, IsObservedAtOtherTimesOfOtherViewers) {
  std::set<uint32_t> first;
  for (size_t nodes = 100'000; nodes < 100'030; ++nodes) first.insert(intervalsOf(nodes, 95'000).front());
  EXPECT_EQ(first.size(), 30u);
}

TEST(RegionShare, IsObservedAtOnceWhenSectionsGrowOrShrink) {
  RegionShare share;
  for (const size_t nodes : {100'000, 115'000, 100'000, 500'000, 50'000}) {
    EXPECT_TRUE(share.isDue(nodes)) << nodes;
    share.observe(share.of(kMotion, kError), nodes, 100'000);
    EXPECT_FALSE(share.isDue(nodes + nodes / 10)) << nodes;
  }
}

TEST(RegionShare, LeavesOutErrorsBeforeMotion) {
  RegionShare share;
  double least_angle = 1e9;
  for (int i = 0; i < 40; ++i) {
    share.observe(share.of(kMotion, kError), 500'000, 100'000);  // whatever the share
    const Region region = share.of(kMotion, kError);
    EXPECT_LE(region.angle_rad, least_angle);
    EXPECT_LE(region.radius_m, kMotion.radius_m + kError.radius_m);
    if (region.angle_rad < kMotion.angle_rad) { EXPECT_LT(region.radius_m, kMotion.radius_m) << "no errors are left"; }
    least_angle = region.angle_rad;
  }
  EXPECT_LT(least_angle, 0.1 * kMotion.angle_rad);
}

// Sections grow with the share by one of several laws, unknown to it and with noise; whatever the law, they are soon
// within kMost and stay there, and are not smaller than they need be.
TEST(RegionShare, KeepsSectionsWithinTheFactorWhateverTheLaw) {
  const uint64_t seed = test::randomSeed();
  Rng rng(seed);
  for (int round = 0; round < 200; ++round) {
    const double most = rng.uniform(0.3, 9), power = rng.uniform(0.6, 1.6);
    RegionShare share;
    int observed = 0;
    for (int i = 0; i < 400; ++i) {
      const double alone = 1e5 * rng.uniform(0.9, 1.1);
      const double nodes = alone * (1 + most * std::pow(share.share(), power));
      if (i > 60) {
        EXPECT_LE(nodes / alone, RegionShare::kMost) << "seed " << seed << ", most " << most << ", power " << power;
        EXPECT_GE(nodes / alone, std::min(1 + most, 1.25)) << "seed " << seed;
      }
      if (!share.isDue(static_cast<size_t>(nodes))) continue;
      ++observed;
      share.observe(share.of(kMotion, kError), static_cast<size_t>(nodes), static_cast<size_t>(alone));
    }
    EXPECT_LE(observed, 201);
  }
}

// What a region adds grows with its angle by one of several laws, and motion and errors grow and fall by any factor
// from one keyframe to the next: no section is larger than allowed, and few are measured while the region stays as it
// is.
TEST(RegionShare, IsReducedBeforeASectionIsTooLarge) {
  const uint64_t seed = test::randomSeed();
  Rng rng(seed);
  int reduced = 0, measured_at_rest = 0;  // of 30,000 keyframes at rest
  for (int round = 0; round < 200; ++round) {
    const double at_a_radian = rng.uniform(0.3, 9), power = rng.uniform(0.8, 1), alone = rng.uniform(2e4, 5e5);
    const auto nodesFor = [&](const Region& region) {
      return static_cast<size_t>(alone * (1 + at_a_radian * std::pow(region.angle_rad, power)));
    };
    RegionShare share;
    double factor = 1;
    for (int i = 0; i < 200; ++i) {
      const bool is_at_rest = i % 20 >= 5;
      if (!is_at_rest) factor = std::exp(rng.uniform(-6, 1));
      const auto regionNow = [&] {
        const Region whole = share.of(kMotion, kError);
        return Region{factor * whole.radius_m, factor * whole.angle_rad};
      };
      const double before = share.share();
      share.fit(regionNow, [&](const Region& region, size_t most) -> std::optional<size_t> {
        measured_at_rest += is_at_rest;
        return nodesFor(region) <= most ? std::optional(nodesFor(region)) : std::nullopt;
      });
      reduced += share.share() < before;
      ASSERT_LE(double(nodesFor(regionNow())) / alone, 1.05 * RegionShare::kMost) << "seed " << seed << ", " << i;
      if (share.isDue(nodesFor(regionNow())))
        share.observe(regionNow(), nodesFor(regionNow()), static_cast<size_t>(alone));
    }
  }
  EXPECT_LE(measured_at_rest, 2000) << "seed " << seed;
  EXPECT_GT(reduced, 500);
}

// A camera that flies straight on after a turn must not leave its regions for long because the turn was hard to
// predict.
TEST(RegionShare, IsWholeAgainSoonAfterTheRegionAddsLittle) {
  const uint64_t seed = test::randomSeed();
  Rng rng(seed);
  for (int round = 0; round < 200; ++round) {
    const double at_a_radian = rng.uniform(3, 9);
    const auto nodesFor = [&](const Region& region) {
      return static_cast<size_t>(1e5 * (1 + at_a_radian * region.angle_rad));
    };
    RegionShare share;
    double factor = 1;
    const auto regionNow = [&] {
      const Region whole = share.of(kMotion, kError);
      return Region{factor * whole.radius_m, factor * whole.angle_rad};
    };
    const auto keyframe = [&] {
      share.fit(regionNow, [&](const Region& region, size_t most) -> std::optional<size_t> {
        return nodesFor(region) <= most ? std::optional(nodesFor(region)) : std::nullopt;
      });
      if (share.isDue(nodesFor(regionNow()))) share.observe(regionNow(), nodesFor(regionNow()), 100'000);
    };
    for (int i = 0; i < 50; ++i) {
      factor = rng.uniform(1, 10);
      keyframe();
    }
    EXPECT_LT(share.share(), 0.6) << "seed " << seed;
    factor = 0.01;
    for (uint32_t i = 0; i < 2 * RegionShare::kOften; ++i) keyframe();
    EXPECT_EQ(share.share(), 1) << "seed " << seed;
  }
}

}  // namespace
}  // namespace foreland::server
