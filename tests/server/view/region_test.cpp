// The region is a bound: nothing that the camera does between two keyframes leaves it, however crooked the motion is.
// And it is a tight one where the motion is smooth.
#include "server/view/region.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <string>

#include "base/rng.h"

namespace foreland::server {
namespace {

// Changed by --gtest_random_seed, as it is printed.
uint64_t seed() { return static_cast<uint64_t>(testing::UnitTest::GetInstance()->random_seed()); }

glm::dquat randomOrientation(Rng& rng) {
  glm::dquat q(1, 0, 0, 0);
  do q = {rng.uniform(-1, 1), rng.uniform(-1, 1), rng.uniform(-1, 1), rng.uniform(-1, 1)};
  while (glm::length(q) < 0.1);
  return glm::normalize(q);
}

// Turned by up to `max_rad` about any axis.
glm::dquat turned(const glm::dquat& q, double max_rad, Rng& rng) {
  const double half = 0.5 * rng.uniform(0, max_rad);
  const glm::dvec3 axis = glm::normalize(glm::dvec3(rng.uniform(0.1, 1), rng.uniform(-1, 1), rng.uniform(-1, 1)));
  return glm::normalize(glm::dquat(std::cos(half), axis * std::sin(half)) * q);
}

// Every pose turns to anywhere and moves in any direction.
proto::Path crookedPath(Duration step, size_t poses, double max_turn_rad, Rng& rng) {
  proto::Path path{Time{static_cast<int64_t>(rng.below(1'000'000))}, step, {}};
  proto::Pose pose{{0, 0, 0}, randomOrientation(rng)};
  for (size_t i = 0; i < poses; ++i) {
    path.poses.push_back(pose);
    pose.eye += glm::dvec3(rng.uniform(-9, 9), rng.uniform(-9, 9), rng.uniform(-9, 9));
    pose.orientation = turned(pose.orientation, max_turn_rad, rng);
  }
  return path;
}

// The smallest region, from poses a tenth of a millisecond apart or, in long intervals, at 100 000 times.
Region sampledRegion(const proto::Pose& centre, const ExpectedMotion& motion, Time begin, Time end) {
  Region region;
  const int64_t span_us = (end - begin).us, samples = std::min<int64_t>(span_us / 100, 100'000);
  for (int64_t i = 0; i <= samples; ++i) {
    const proto::Pose pose = motion.at(begin + Duration{span_us * i / samples});
    region.radius_m = std::max(region.radius_m, glm::distance(pose.eye, centre.eye));
    region.angle_rad = std::max(region.angle_rad, proto::angleBetween(pose.orientation, centre.orientation));
  }
  return region;
}

void expectHolds(const ExpectedMotion& motion, Time begin, Time at, Time end, const std::string& what) {
  const proto::Pose centre = motion.at(at);
  const Region bound = regionOf(centre, motion, begin, end), sampled = sampledRegion(centre, motion, begin, end);
  EXPECT_GE(bound.radius_m + 1e-6, sampled.radius_m) << what << ", seed " << seed();
  EXPECT_GE(bound.angle_rad + 1e-6, sampled.angle_rad) << what << ", seed " << seed();
}

TEST(Region, HoldsEveryPoseOfAPathWithKinksAtAnyStep) {
  Rng rng(seed());
  for (const int64_t step_us : {1'000, 3'000, 7'000, 20'000, 33'000, 100'000, 500'000})
    for (int round = 0; round < 60; ++round) {
      const proto::Path path = crookedPath(Duration{step_us}, 400'000 / static_cast<size_t>(step_us) + 5, 3.1, rng);
      const Time begin = path.start + Duration{static_cast<int64_t>(rng.below(3)) * 10'000 - 10'000};
      const Duration span = Duration::milliseconds(20 << rng.below(5));
      expectHolds(ExpectedMotion(path), begin, begin + Duration{span.us / 2}, begin + span,
                  "step " + std::to_string(step_us) + " us, round " + std::to_string(round));
    }
}

// Catmull-Rom swings beyond two equal eyes, here by an eighth of a metre, between two samples that are both at 1 m.
TEST(Region, HoldsASwingBetweenTwoSamples) {
  proto::Path path{Time{}, Duration::milliseconds(20), {}};
  for (const double x : {0, 0, 1, 1, 0, 0}) path.poses.push_back({{x, 0, 0}, {1, 0, 0, 0}});
  const Region region = regionOf(path.poses[0], ExpectedMotion(path), Time{}, path.end());
  EXPECT_GE(region.radius_m, 1.125);
  EXPECT_LE(region.radius_m, 1.4);
}

// More than 200 steps of 20 ms, so that each is longer.
TEST(Region, HoldsEveryPoseOfALongInterval) {
  Rng rng(seed());
  for (const int64_t step_ms : {10, 250, 3'000}) {
    const proto::Path path =
        crookedPath(Duration::milliseconds(step_ms), 30'000 / static_cast<size_t>(step_ms) + 4, 3.1, rng);
    for (const double seconds : {5.0, 29.0})
      expectHolds(ExpectedMotion(path), path.start, path.start + Duration::seconds(seconds / 2),
                  path.start + Duration::seconds(seconds), std::to_string(step_ms) + " ms, " + std::to_string(seconds));
  }
}

TEST(Region, HoldsEveryPoseOfACrookedPastAndItsPrediction) {
  Rng rng(seed());
  for (int round = 0; round < 30; ++round) {
    PoseHistory history;
    const proto::Path past = crookedPath(Duration::milliseconds(50), 40, 1.5, rng);
    Time t;
    for (const proto::Pose& pose : past.poses) {
      history.add({t, pose});
      t = t + Duration{static_cast<int64_t>(1'000 + rng.below(80'000))};
    }
    const Time newest = history.newest().time;
    for (const auto predictor :
         {proto::Predictor::kHold, proto::Predictor::kConstantVelocity, proto::Predictor::kConstantAcceleration})
      for (const int64_t ahead_ms : {-500, 0, 150, 2'900, 5'000}) {
        const Time at = newest + Duration::milliseconds(ahead_ms);
        expectHolds(ExpectedMotion(history, predictor), at - Duration::milliseconds(230), at,
                    at + Duration::milliseconds(200),
                    "round " + std::to_string(round) + ", ahead " + std::to_string(ahead_ms) + " ms, " +
                        proto::name(predictor));
      }
  }
}

// The camera may spin through more than half a turn between two steps.
TEST(Region, IsAWholeTurnIfTheCameraSpinsTooFastToFollow) {
  PoseHistory history;
  const glm::dquat quarter_turned(std::sqrt(0.5), 0, 0, std::sqrt(0.5));
  history.add({Time{0}, {{0, 0, 0}, {1, 0, 0, 0}}});
  history.add({Time{2'000}, {{0, 0, 0}, quarter_turned}});
  const ExpectedMotion motion(history, proto::Predictor::kConstantVelocity);
  const Time now{2'000};
  EXPECT_GE(regionOf(motion.at(now), motion, now, now + Duration{200'000}).angle_rad, 3.14159265);
}

TEST(Region, IsWithinOnePercentOfTheSmallestOnAStraightTour) {
  proto::Path path{Time{}, Duration::milliseconds(100), {}};
  for (int i = 0; i < 50; ++i) path.poses.push_back({{15.0 * i, -3.0 * i, 0.5 * i}, {1, 0, 0, 0}});
  const ExpectedMotion motion(path);
  const Time begin = Time::seconds(1), at = Time::seconds(1.2), end = Time::seconds(1.4);
  const Region smallest = sampledRegion(motion.at(at), motion, begin, end);
  EXPECT_LE(regionOf(motion.at(at), motion, begin, end).radius_m, 1.01 * smallest.radius_m);
}

TEST(Region, OfACameraAtRestIsEmpty) {
  const proto::Path path{Time{}, Duration::milliseconds(100), {2, proto::Pose{{1, 2, 3}, {1, 0, 0, 0}}}};
  const Region region = regionOf(path.poses[0], ExpectedMotion(path), Time{}, Time::seconds(3));
  EXPECT_LT(region.radius_m, 1e-9);
  EXPECT_LT(region.angle_rad, 1e-9);
}

}  // namespace
}  // namespace foreland::server
