// The recent past of a camera, and where it is taken to go from there.
#include "server/view/pose_history.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <glm/geometric.hpp>

namespace foreland::server {
namespace {

using enum proto::Predictor;

// About the vertical axis.
glm::dquat heading(double rad) { return {std::cos(rad / 2), 0, 0, std::sin(rad / 2)}; }

// Every 20 ms, up to and with `last_s`: the eye by a formula of the time in seconds, turning evenly.
PoseHistory historyOf(double last_s, const std::function<glm::dvec3(double)>& eye_at, double turn_rad_per_s = 0) {
  PoseHistory history;
  for (int64_t us = 0; us <= std::llround(last_s * 1e6); us += 20'000) {
    const double t = static_cast<double>(us) * 1e-6;
    history.add({Time{us}, {eye_at(t), heading(turn_rad_per_s * t)}});
  }
  return history;
}

void expectNear(const glm::dvec3& got, const glm::dvec3& expected, double tolerance_m) {
  EXPECT_LE(glm::distance(got, expected), tolerance_m) << got.x << ", " << got.y << ", " << got.z << " instead of "
                                                       << expected.x << ", " << expected.y << ", " << expected.z;
}

TEST(PoseHistory, InterpolatesBetweenItsPosesAndHoldsOutsideOfThem) {
  PoseHistory history;
  history.add({Time{1'000'000}, {{0, 0, 0}, heading(0)}});
  history.add({Time{2'000'000}, {{10, 0, -4}, heading(0.8)}});
  const proto::Pose quarter = history.at(Time{1'250'000});
  expectNear(quarter.eye, {2.5, 0, -1}, 1e-12);
  EXPECT_LT(proto::angleBetween(quarter.orientation, heading(0.2)), 1e-9);
  EXPECT_EQ(history.at(Time{0}).eye, glm::dvec3(0, 0, 0));
  EXPECT_EQ(history.at(Time{9'000'000}).eye, glm::dvec3(10, 0, -4));
}

TEST(PoseHistory, DropsPosesThatAreNotNewer) {
  PoseHistory history;
  history.add({Time{5}, {{1, 0, 0}, heading(0)}});
  history.add({Time{5}, {{2, 0, 0}, heading(0)}});
  history.add({Time{4}, {{3, 0, 0}, heading(0)}});
  EXPECT_EQ(history.newest().pose.eye, glm::dvec3(1, 0, 0));
}

TEST(PoseHistory, KeepsTheLastPosesOnly) {
  PoseHistory history;
  const auto count = static_cast<int64_t>(PoseHistory::kCapacity) + 10;
  for (int64_t i = 0; i < count; ++i) history.add({Time{i}, {{static_cast<double>(i), 0, 0}, heading(0)}});
  EXPECT_EQ(history.at(Time{0}).eye.x, PoseHistory::kCapacity / 2);
  EXPECT_EQ(history.newest().time, Time{count - 1});
}

TEST(PoseHistory, PredictsEvenMotionAndTurningExactly) {
  const glm::dvec3 velocity(30, -7, 2);
  const PoseHistory history = historyOf(
      0.6, [&](double t) { return velocity * t; }, 0.9);
  for (const auto predictor : {kConstantVelocity, kConstantAcceleration, kKnownPath, kDoubleExponential}) {
    const proto::Pose pose = history.predict(predictor, Time::seconds(1.1));
    expectNear(pose.eye, velocity * 1.1, 1e-9);
    EXPECT_LT(proto::angleBetween(pose.orientation, heading(0.99)), 1e-9);
  }
}

TEST(PoseHistory, PredictsEvenAccelerationExactlyWithTheAccelerationPredictorAlone) {
  const auto eye_at = [](double t) { return glm::dvec3(5 * t, 3 * t * t, -4 * t * t); };
  const PoseHistory history = historyOf(0.6, eye_at);
  expectNear(history.predict(kConstantAcceleration, Time::seconds(1)).eye, eye_at(1), 1e-9);
  EXPECT_GT(glm::distance(history.predict(kConstantVelocity, Time::seconds(1)).eye, eye_at(1)), 0.5);
}

TEST(PoseHistory, PredictsEvenAccelerationAndTurningNearlyExactlyByAKalmanFilter) {
  const auto eye_at = [](double t) { return glm::dvec3(5 * t, 3 * t * t, -4 * t * t); };
  const PoseHistory history = historyOf(4, eye_at, 0.9);
  const proto::Pose pose = history.predict(kKalman, Time::seconds(4.5));
  expectNear(pose.eye, eye_at(4.5), 0.02);
  EXPECT_LT(proto::angleBetween(pose.orientation, heading(0.9 * 4.5)), 1e-3);
  EXPECT_GT(glm::distance(history.predict(kConstantVelocity, Time::seconds(4.5)).eye, eye_at(4.5)), 1);
}

// A camera that shakes about a straight path moves on straight for a filter; by its last poses it would fly aside.
TEST(PoseHistory, SmoothsWhatShakes) {
  const auto eye_at = [](double t) { return glm::dvec3(30 * t, 0.05 * std::sin(60 * t), 0); };
  double velocity_m = 0, smoothed_m = 0;
  for (double last_s = 2; last_s < 2.2; last_s += 0.02) {
    const PoseHistory history = historyOf(last_s, eye_at);
    const Time t = history.newest().time + Duration::milliseconds(500);
    velocity_m = std::max(velocity_m, std::fabs(history.predict(kConstantVelocity, t).eye.y));
    smoothed_m = std::max(smoothed_m, std::fabs(history.predict(kDoubleExponential, t).eye.y));
  }
  EXPECT_LT(smoothed_m, 0.7 * velocity_m);
}

TEST(PoseHistory, ForgetsWhatItFilteredWhenTheCameraJumps) {
  PoseHistory history = historyOf(1, [](double t) { return glm::dvec3(40 * t, 0, 0); });
  history.restart({Time{1'100'000}, {{900, 0, 0}, heading(0)}});
  history.add({Time{1'150'000}, {{900, 0, 0}, heading(0)}});
  for (const auto predictor : {kDoubleExponential, kKalman})
    expectNear(history.predict(predictor, Time{1'400'000}).eye, {900, 0, 0}, 1e-9);
}

TEST(PoseHistory, StandsStillWithHoldWithOnePoseAndBeyondTheHorizon) {
  const PoseHistory history = historyOf(0.6, [](double t) { return glm::dvec3(40 * t, 0, 0); });
  EXPECT_EQ(history.predict(kHold, Time::seconds(2)).eye, history.newest().pose.eye);
  const Time horizon = history.newest().time + PoseHistory::kHorizon;
  EXPECT_EQ(history.predict(kConstantVelocity, horizon + Duration::seconds(5)).eye,
            history.predict(kConstantVelocity, horizon).eye);
  PoseHistory single;
  single.add({Time{0}, {{1, 2, 3}, heading(0.3)}});
  EXPECT_EQ(single.predict(kConstantAcceleration, Time::seconds(1)).eye, glm::dvec3(1, 2, 3));
}

// Over a baseline of four intervals, not from the last two poses, whose rounding would be magnified.
TEST(PoseHistory, TakesTheVelocityOverABaseline) {
  PoseHistory history = historyOf(0.6, [](double t) { return glm::dvec3(10 * t, 0, 0); });
  history.add({Time{600'100}, {{6.101, 0, 0}, heading(0)}});  // 0.1 m off; by the last two poses 1000 m/s
  EXPECT_LT(glm::length(history.extrapolate(kConstantVelocity).velocity), 13);
}

TEST(PoseHistory, NamesItsCornersInOrder) {
  PoseHistory history;
  history.add({Time{10}, {{0, 0, 0}, heading(0)}});
  history.add({Time{30}, {{1, 0, 0}, heading(0)}});
  EXPECT_EQ(history.nextCorner(Time{5}), Time{10});
  EXPECT_EQ(history.nextCorner(Time{10}), Time{30});
  const Time horizon = Time{30} + PoseHistory::kHorizon;
  EXPECT_EQ(history.nextCorner(Time{30}), horizon);
  EXPECT_EQ(history.nextCorner(horizon), std::nullopt);
}

}  // namespace
}  // namespace foreland::server
