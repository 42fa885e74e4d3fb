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
constexpr RegionParts kParts{kMotion, kError, {}};

TEST(RegionShare, IsTheWholeRegionWhereItAddsLittle) {
  RegionShare share;
  for (int i = 0; i < 100; ++i)
    if (share.isDue(130'000)) share.observe(kParts, 130'000, 100'000);
  EXPECT_EQ(share.share(), 1);
  EXPECT_EQ(share.coarser(), 1);
  EXPECT_DOUBLE_EQ(share.of(kParts).radius_m, kMotion.radius_m + kError.radius_m);
  EXPECT_DOUBLE_EQ(share.of(kParts).angle_rad, kMotion.angle_rad + kError.angle_rad);
}

TEST(RegionShare, IsTheLargestThatWhatIsLeftHoldsOfTheWhole) {
  Rng rng(test::randomSeed());
  RegionShare share;
  EXPECT_EQ(share.shareOf(kParts), 1);
  int reduced = 0;
  for (int i = 0; i < 300; ++i) {
    share.observe(kParts, 100'000 + rng.below(1'000'000), 100'000);
    const auto some = [&] {
      return Region{rng.below(4) == 0 ? 0 : 100 * rng.uniform(), rng.below(4) == 0 ? 0 : rng.uniform()};
    };
    const RegionParts parts{some(), some(), some()};
    const Region left = share.of(parts);
    const double radius_m = parts.motion.radius_m + parts.error.radius_m + parts.rest.radius_m,
                 angle_rad = parts.motion.angle_rad + parts.error.angle_rad + parts.rest.angle_rad;
    const double of_whole = share.shareOf(parts);
    EXPECT_LE(of_whole * radius_m, left.radius_m * (1 + 1e-12));
    EXPECT_LE(of_whole * angle_rad, left.angle_rad * (1 + 1e-12));
    const double more = of_whole + 1e-9;
    EXPECT_TRUE(of_whole == 1 || more * radius_m > left.radius_m || more * angle_rad > left.angle_rad);
    reduced += of_whole < 1;
  }
  EXPECT_GT(reduced, 50);
}

// The keyframes between observations of a section of a steady size.
std::vector<uint32_t> intervalsOf(size_t nodes, size_t without_errors) {
  RegionShare share;
  std::vector<uint32_t> intervals;
  uint32_t since = 0;
  for (int i = 0; i < 1000; ++i) {
    ++since;
    if (!share.isDue(nodes)) continue;
    share.observe(kParts, nodes, without_errors);
    intervals.push_back(std::exchange(since, 0));
  }
  EXPECT_EQ(intervals.front(), 1u);
  intervals.erase(intervals.begin());
  return intervals;
}

TEST(RegionShare, IsObservedSeldomWhileSectionsStayAsLarge) {
  for (const auto& [without_errors, most] : {std::pair{100'000u, RegionShare::kSeldom}, {80'000u, RegionShare::kOften}})
    for (const uint32_t interval : intervalsOf(110'000, without_errors)) {
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
    share.observe(kParts, nodes, 100'000);
    EXPECT_FALSE(share.isDue(nodes + nodes / 10)) << nodes;
  }
}

// However much errors take, what is expected of the motion is guaranteed.
TEST(RegionShare, LeavesOutErrorsAlone) {
  RegionShare share;
  double min_angle = 1e9;
  for (int i = 0; i < 40; ++i) {
    share.observe(kParts, 5'000'000, 100'000);  // whatever the share
    const Region region = share.of(kParts);
    EXPECT_LE(region.angle_rad, min_angle);
    EXPECT_GE(region.angle_rad, kMotion.angle_rad);
    EXPECT_GE(region.radius_m, kMotion.radius_m);
    EXPECT_LE(region.radius_m, kMotion.radius_m + kError.radius_m);
    min_angle = region.angle_rad;
  }
  EXPECT_LT(min_angle, kMotion.angle_rad + 0.1 * kError.angle_rad);
}

// Keyframes of a viewer. What errors add to sections grows with their angle by a law, and sections shrink with the
// tolerance by another.
struct Keyframes {
  double alone, at_a_radian, power;  // nodes without errors; how many times as many a radian of them adds
  double node_power = RegionShare::kNodePower;
  RegionShare share{};
  double factor = 1;  // of motion and errors
  int measured = 0;   // sections before they were sent

  size_t nodes() const { return nodesFor(share.of(parts())); }  // at the wanted tolerance
  double nodesSent() const { return static_cast<double>(nodes()) * std::pow(share.coarser(), -node_power); }
  void next() {
    share.fit(parts(), [&](const Region& region, size_t most) -> std::optional<size_t> {
      ++measured;
      return nodesFor(region) <= most ? std::optional(nodesFor(region)) : std::nullopt;
    });
  }
  void observe() {
    if (share.isDue(nodes())) share.observe(parts(), nodes(), static_cast<size_t>(alone));
  }

 private:
  RegionParts parts() const {
    return {{factor * kMotion.radius_m, factor * kMotion.angle_rad},
            {factor * kError.radius_m, factor * kError.angle_rad},
            {}};
  }
  size_t nodesFor(const Region& region) const {
    const double error_rad = std::max(0.0, region.angle_rad - factor * kMotion.angle_rad);
    return static_cast<size_t>(alone * (1 + at_a_radian * std::pow(error_rad, power)));
  }
};

// Sections grow with errors by one of several laws, unknown to it and with noise; whatever the law, they are soon
// within kMax at the tolerance that is chosen and stay there, and are not smaller than they need be.
TEST(RegionShare, KeepsSectionsWithinTheFactorWhateverTheLaw) {
  const uint64_t seed = test::randomSeed();
  Rng rng(seed);
  int coarser = 0, reduced = 0;
  for (int round = 0; round < 200; ++round) {
    Keyframes keyframes{1e5, std::exp(rng.uniform(-1, 4)), rng.uniform(0.6, 1.6), rng.uniform(0.9, 1.2)};
    for (int i = 0; i < 400; ++i) {
      keyframes.alone = 1e5 * rng.uniform(0.97, 1.03);
      keyframes.next();
      if (i > 60) {
        const double times = keyframes.nodesSent() / keyframes.alone,
                     whole = static_cast<double>(keyframes.nodes()) / keyframes.alone;
        ASSERT_LE(times, 1.1 * RegionShare::kMax) << "seed " << seed << ", " << round;
        ASSERT_GE(times, std::min(whole, 0.6 * RegionShare::kMax)) << "seed " << seed << ", " << round;
      }
      keyframes.observe();
    }
    coarser += keyframes.share.coarser() > 1;
    reduced += keyframes.share.share() < 1;
  }
  EXPECT_GT(coarser, 50) << "seed " << seed;
  EXPECT_GT(reduced, 50) << "seed " << seed;
}

// Motion and errors grow and fall by any factor from one keyframe to the next: no section is larger than allowed, and
// few are measured while the region stays as it is.
TEST(RegionShare, IsReducedBeforeASectionIsTooLarge) {
  const uint64_t seed = test::randomSeed();
  Rng rng(seed);
  int coarser = 0, reduced = 0, measured_at_rest = 0;  // of 30,000 keyframes at rest
  for (int round = 0; round < 200; ++round) {
    Keyframes keyframes{rng.uniform(2e4, 5e5), rng.uniform(0.3, 12), rng.uniform(0.8, 1)};
    for (int i = 0; i < 200; ++i) {
      const bool is_at_rest = i % 20 >= 5;
      if (!is_at_rest) keyframes.factor = std::exp(rng.uniform(-6, 1));
      const double before = keyframes.share.share();
      const int measured = keyframes.measured;
      keyframes.next();
      if (is_at_rest) measured_at_rest += keyframes.measured - measured;
      reduced += keyframes.share.share() < before;
      coarser += keyframes.share.coarser() > 1;
      ASSERT_LE(keyframes.nodesSent() / keyframes.alone, 1.05 * RegionShare::kMax) << "seed " << seed << ", " << i;
      keyframes.observe();
    }
  }
  EXPECT_LE(measured_at_rest, 2000) << "seed " << seed;
  EXPECT_GT(coarser, 500);
  EXPECT_GT(reduced, 100);
}

// A camera that flies straight on after a turn must not be coarse, nor leave its regions, for long because the turn was
// hard to predict.
TEST(RegionShare, IsWholeAgainSoonAfterErrorsAddLittle) {
  const uint64_t seed = test::randomSeed();
  Rng rng(seed);
  for (int round = 0; round < 200; ++round) {
    Keyframes keyframes{1e5, rng.uniform(3, 9), 1};
    for (int i = 0; i < 50; ++i) {
      keyframes.factor = rng.uniform(3, 20);
      keyframes.next();
      keyframes.observe();
    }
    EXPECT_LT(keyframes.share.share(), 0.8) << "seed " << seed;
    EXPECT_GT(keyframes.share.coarser(), 2) << "seed " << seed;
    keyframes.factor = 0.01;
    for (uint32_t i = 0; i < 2 * RegionShare::kOften; ++i) {
      keyframes.next();
      keyframes.observe();
    }
    EXPECT_EQ(keyframes.share.share(), 1) << "seed " << seed;
    EXPECT_EQ(keyframes.share.coarser(), 1) << "seed " << seed;
  }
}

}  // namespace
}  // namespace foreland::server
