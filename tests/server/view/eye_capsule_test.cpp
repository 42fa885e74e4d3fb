// A capsule is a bound: the eye never leaves it, however crooked the motion is. And it is a tight one along a line.
#include "server/view/eye_capsule.h"

#include <gtest/gtest.h>

#include <glm/geometric.hpp>

#include "base/rng.h"

namespace foreland::server {
namespace {

// Distance from the nearest of many points of the capsule's segment: from above.
double distanceFrom(const EyeCapsule& capsule, const glm::dvec3& p) {
  double least = glm::distance(capsule.eye, p);
  for (int i = 1; i <= 2000; ++i) least = std::min(least, glm::distance(capsule.eye + i / 2000.0 * capsule.way, p));
  return least;
}

proto::Path crookedPath(Rng& rng, double max_m) {
  proto::Path path{Time{static_cast<int64_t>(rng.below(1'000'000))}, Duration::milliseconds(100), {}};
  glm::dvec3 eye(0);
  for (int i = 0; i < 80; ++i) {
    path.poses.push_back({eye, {1, 0, 0, 0}});
    eye += max_m * glm::dvec3(rng.uniform(-1, 1), rng.uniform(-1, 1), rng.uniform(-1, 1));
  }
  return path;
}

TEST(EyeCapsule, HoldsTheEyeAtAllTimes) {
  const uint64_t seed = static_cast<uint64_t>(testing::UnitTest::GetInstance()->random_seed());
  SCOPED_TRACE(testing::Message() << "seed " << seed);
  Rng rng(seed);
  for (int round = 0; round < 60; ++round) {
    const proto::Path path = crookedPath(rng, rng.uniform(0, 20));
    const ExpectedMotion motion(path);
    const Time begin = path.start + Duration{static_cast<int64_t>(rng.below(6'000'000))},
               end = begin + Duration{static_cast<int64_t>(rng.below(4'000'000))};
    const EyeCapsule capsule = capsuleOf(motion, begin, end);
    const double coarseness_m = glm::length(capsule.way) / 2000;
    for (int i = 0; i < 300; ++i) {
      const Time t = begin + Duration{static_cast<int64_t>(rng.below((end - begin).us + 1))};
      ASSERT_LE(distanceFrom(capsule, motion.at(t).eye), capsule.radius_m + coarseness_m + 1e-6);
    }
  }
}

TEST(EyeCapsule, IsALineAlongAStraightFlight) {
  proto::Path path{Time{}, Duration::milliseconds(100), {}};
  for (int i = 0; i < 60; ++i) path.poses.push_back({{15.0 * i, 3.0 * i, 0}, {1, 0, 0, 0}});
  const EyeCapsule capsule = capsuleOf(ExpectedMotion(path), Time::seconds(1), Time::seconds(4));
  EXPECT_LT(capsule.radius_m, 0.01);
  EXPECT_NEAR(glm::length(capsule.way), 3 * glm::length(glm::dvec2(150, 30)), 0.01);
}

TEST(EyeCapsule, ContainsThoseWhoseEyesItHolds) {
  const EyeCapsule capsule{{0, 0, 0}, {100, 0, 0}, 10};
  EXPECT_TRUE(capsule.contains(capsule));
  EXPECT_TRUE(capsule.contains({{20, 3, 0}, {60, 2, 0}, 4}));
  EXPECT_FALSE(capsule.contains({{20, 3, 0}, {60, 2, 0}, 6}));
  EXPECT_FALSE(capsule.contains({{20, 3, 0}, {90, 0, 0}, 0.5}));
  EXPECT_TRUE(capsule.contains({{20, 3, 0}, {87, -3, 0}, 1}));
}

}  // namespace
}  // namespace foreland::server
