#include "server/view/viewer_motion.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <glm/geometric.hpp>

#include "base/rng.h"
#include "tests/support/seed.h"

namespace foreland::server {
namespace {

constexpr Duration kInterval = Duration::milliseconds(200);

// A camera that flies, turns and brakes at random from a place on, with poses at uneven times.
class Flight {
 public:
  Flight(Rng& rng, Time begin, const glm::dvec3& eye) : rng_(rng) { pose_ = {begin, {eye, {1, 0, 0, 0}}}; }
  proto::TimedPose next() {
    const Duration step{10'000 + static_cast<int64_t>(rng_.below(60'000))};
    velocity_ += glm::dvec3(rng_.uniform(-9, 9), rng_.uniform(-9, 9), rng_.uniform(-3, 3));
    pose_.time = pose_.time + step;
    pose_.pose.eye += velocity_ * step.toSeconds();
    const double half = 0.5 * rng_.uniform(-0.05, 0.05);
    pose_.pose.orientation = glm::normalize(pose_.pose.orientation * glm::dquat(std::cos(half), 0, 0, std::sin(half)));
    return pose_;
  }
  const proto::TimedPose& pose() const { return pose_; }

 private:
  Rng& rng_;
  proto::TimedPose pose_;
  glm::dvec3 velocity_{0};
};

void add(ViewerMotion& motion, const proto::TimedPose& pose, const proto::ViewRequest& request) {
  motion.add(pose);
  const Time later = pose.time + kInterval;
  motion.notePrediction({later, motion.expected(request).at(later)}, kInterval);
}

Region regionOf(const ViewerMotion& motion, const proto::ViewRequest& request) {
  const ExpectedMotion expected = motion.expected(request);
  const Time now = motion.newest().time;
  return motion.regionShare().of(
      motion.regionAround(expected.at(now + kInterval), expected, now, now + kInterval, kInterval, kInterval));
}

constexpr std::array kPredictors{proto::Predictor::kHold, proto::Predictor::kConstantVelocity,
                                 proto::Predictor::kConstantAcceleration, proto::Predictor::kDoubleExponential,
                                 proto::Predictor::kKalman};

// Else a camera that is shown late would have the region of the flight before for ever, and its section with it.
TEST(ViewerMotion, ErrorsAreForgottenOnceKeyframesAreForPosesThatAreKnown) {
  const uint64_t seed = test::randomSeed();
  SCOPED_TRACE("seed " + std::to_string(seed));
  Rng rng(seed);
  const proto::ViewRequest request;
  ViewerMotion motion;
  Flight flight(rng, Time::seconds(1), {0, 0, 500});
  for (int i = 0; i < 30; ++i) add(motion, flight.next(), request);
  const auto error = [&] {
    const Time now = motion.newest().time;
    const ExpectedMotion expected = motion.expected(request);
    return motion.regionAround(expected.at(now), expected, now, now, kInterval, kInterval).error;
  };
  ASSERT_GT(error().radius_m, 0.01);
  const Time pending_until = motion.newest().time + kInterval;
  for (size_t known = 0; known < PredictionErrors::kMemory;) {
    if (motion.newest().time >= pending_until) ++known;
    motion.add(flight.next());
    const Time now = motion.newest().time;
    motion.notePrediction({now, motion.expected(request).at(now)}, kInterval);
  }
  EXPECT_EQ(error().radius_m, 0);
  EXPECT_LT(error().angle_rad, 1e-12);
}

// Of the motion before a jump nothing is left but, until poses tell a velocity, how fast it was. Where the camera stood
// that is nothing.
TEST(ViewerMotion, AfterAJumpIsThatOfAViewerWhoBeginsThere) {
  const uint64_t seed = test::randomSeed();
  SCOPED_TRACE("seed " + std::to_string(seed));
  Rng rng(seed);
  for (int round = 0; round < 200; ++round) {
    proto::ViewRequest request;
    request.predictor = kPredictors[rng.below(kPredictors.size())];
    const bool stands = rng.below(2) == 0;
    ViewerMotion jumped, fresh;
    Flight before(rng, Time::seconds(1), {0, 0, 500});
    for (uint64_t i = rng.below(60); i-- > 0;) {
      proto::TimedPose pose = before.next();
      if (stands) pose.pose = proto::Pose{{0, 0, 500}, {1, 0, 0, 0}};
      add(jumped, pose, request);
    }
    if (!stands && rng.below(2) == 0 && !jumped.empty())
      jumped.regionShare().observe({{}, {10, 0.1}, {}}, 900'000, 100'000);
    Flight after(rng, before.pose().time, before.pose().pose.eye + glm::dvec3(300, 0, 0));
    const proto::TimedPose first = after.next();
    jumped.jumpTo(first);
    add(fresh, first, request);
    for (int i = 0; i < 20; ++i) {
      const Time later = fresh.newest().time + kInterval;
      const proto::Pose a = jumped.expected(request).at(later), b = fresh.expected(request).at(later);
      EXPECT_EQ(a.eye, b.eye);
      EXPECT_EQ(a.orientation, b.orientation);
      const Region region = regionOf(jumped, request), least = regionOf(fresh, request);
      const bool is_told = fresh.newest().time - first.time >= PoseHistory::kBaseline;
      EXPECT_GE(region.radius_m, least.radius_m);
      EXPECT_LE(region.radius_m, least.radius_m + (stands || is_told ? 0 : 1000));
      if (stands || is_told) { EXPECT_NEAR(region.angle_rad, least.angle_rad, 1e-6); }
      if (i == 0) jumped.notePrediction({later, a}, kInterval);
      const proto::TimedPose next = after.next();
      for (ViewerMotion* motion : {&jumped, &fresh}) add(*motion, next, request);
    }
  }
}

TEST(ViewerMotion, AJumpForgetsAPathThatDoesNotPassThere) {
  proto::ViewRequest request;
  request.predictor = proto::Predictor::kKnownPath;
  const proto::Pose here{{0, 0, 500}, {1, 0, 0, 0}};
  for (const double away_m : {0.0, 300.0}) {
    ViewerMotion motion;
    motion.add({Time::seconds(1), here});
    motion.announce({.start = Time::seconds(1), .step = Duration::seconds(1), .poses = {here, here}});
    motion.jumpTo({Time::seconds(1.1), {{away_m, 0, 500}, {1, 0, 0, 0}}});
    EXPECT_EQ(motion.isOnPath(request), away_m == 0);
  }
}

}  // namespace
}  // namespace foreland::server
