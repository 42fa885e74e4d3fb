#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>

#include "base/rng.h"
#include "client/fly/track_path.h"
#include "client/fly/tracks/track.h"
#include "tests/client/fly/alpine_tile.h"
#include "tests/support/data.h"

namespace foreland::client {
namespace {

// A camera that flies along x in a model of length 1, looks along it, and turns left by 0.01 rad a frame.
std::string frames(size_t count) {
  std::string text;
  for (size_t i = 0; i < count; ++i) {
    const double a = 0.01 * static_cast<double>(i), x = static_cast<double>(i) / static_cast<double>(count - 1);
    char line[400];
    std::snprintf(line, sizeof line, "F 0  %.9f %.9f 0  %.9f %.9f 0  0 0 1  %.9f 0.25 0.01  0.5\nf 0 0 0\n",
                  std::cos(a), std::sin(a), -std::sin(a), std::cos(a), x);
    text += line;
  }
  return text + "keys Dt\n";
}

proto::Frame planarFrame() {
  proto::Frame frame;
  frame.axis_x_m = {10, 0};
  frame.axis_y_m = {0, 10};
  return frame;
}
TEST(CameraFrames, AreReadWithTheirAxesAtThirtyASecond) {
  const auto track = parseCameraFrames(frames(61), "a.frames");
  ASSERT_TRUE(track.ok()) << track.error().message;
  ASSERT_EQ(track->cameras.size(), 61u);
  EXPECT_TRUE(track->fixes.empty());
  EXPECT_NEAR(track->seconds(), 2, 1e-12);
  for (size_t i = 0; i < 61; ++i) {
    const CameraFrame& c = track->cameras[i];
    const double a = 0.01 * static_cast<double>(i);
    EXPECT_NEAR(c.time_s, static_cast<double>(i) / 30, 1e-12);
    const glm::dvec3 forward = c.orientation * glm::dvec3(0, 0, -1), up = c.orientation * glm::dvec3(0, 1, 0);
    EXPECT_LT(glm::distance(forward, glm::dvec3(std::cos(a), std::sin(a), 0)), 1e-8);
    EXPECT_LT(glm::distance(up, glm::dvec3(0, 0, 1)), 1e-8);
  }
}

TEST(CameraFrames, AreSkippedWithTheirLineWhereTheyAreNone) {
  const auto track =
      parseCameraFrames("F 0 1 0 0\n" + frames(2) + "F 0  2 0 0  0 1 0  0 0 1  0 0 0  0.5\n" +
                            "F 0  1 0 0  0 -1 0  0 0 1  0 0 0  0.5\nF 0  1 0 0  0 1 0  0 0 1  0 nan 0  0.5\n",
                        "a.frames");
  ASSERT_TRUE(track.ok());
  EXPECT_EQ(track->cameras.size(), 2u);
  EXPECT_EQ(track->skipped, 4u);
  EXPECT_NE(track->notes.front().find("a.frames:1: "), std::string::npos);
  const auto none = parseCameraFrames("F 0 1 0 0\n", "a.frames");
  ASSERT_FALSE(none.ok());
  EXPECT_NE(none.error().message.find("a.frames"), std::string::npos);
}

TEST(CameraFrames, SurviveMutation) {
  const uint64_t seed = testing::UnitTest::GetInstance()->random_seed();
  SCOPED_TRACE("seed " + std::to_string(seed));
  Rng rng(seed);
  const std::string sound = frames(4);
  for (int round = 0; round < 5'000; ++round) {
    std::string text = sound;
    for (uint64_t edits = 1 + rng.below(6); edits > 0; --edits) {
      const size_t at = rng.below(text.size());
      text[at] = static_cast<char>(rng.below(3) == 0 ? rng.below(256) : text[rng.below(text.size())]);
    }
    const auto track = parseCameraFrames(text, "x");
    if (!track.ok()) continue;
    ASSERT_GE(track->cameras.size(), 2u);
    for (const CameraFrame& c : track->cameras) {
      ASSERT_LT(std::fabs(glm::length(c.orientation) - 1), 1e-6);
      ASSERT_TRUE(std::isfinite(glm::length(c.eye)));
    }
  }
}

// On either kind of frame: inside the data, over nine tenths of it, looking where the recorded camera looked.
TEST(CameraFrames, AreLaidOnTheScene) {
  const auto track = parseCameraFrames(frames(61), "a.frames");
  ASSERT_TRUE(track.ok());
  for (const proto::Frame& data : {planarFrame(), alpineFrame()}) {
    const proto::FrameTransform frame(data);
    const TrackOptions options;
    const auto plan = planTrack(*track, frame, kShape, options);
    ASSERT_TRUE(plan.ok()) << plan.error().message;
    EXPECT_NEAR(plan->positions.front().x, 0.05 * 1200, 0.01);
    EXPECT_NEAR(plan->positions.back().x, 0.95 * 1200, 0.01);
    EXPECT_NEAR(plan->positions.front().y, 600, 1e-6);
    const std::vector<float> ground(plan->positions.size(), 300);
    const auto path = pathOverGround(*plan, frame, ground, options);
    ASSERT_TRUE(path.ok()) << path.error().message;
    EXPECT_EQ(path->lifted, 0u);
    const proto::Pose first = path->path.at({}), last = path->path.at(path->path.end());
    const double width_m = glm::distance(first.eye, last.eye) / 0.9;
    EXPECT_NEAR(frame.toLattice(first.eye).height_m, 300 + 0.01 * 0.9 * width_m, 1e-3 * width_m);
    EXPECT_GT(glm::dot(first.forward(), glm::normalize(last.eye - first.eye)), 0.99);
    EXPECT_GT(glm::dot(first.up(), frame.upAt(first.eye)), 1 - 1e-6);
    const glm::dvec3 up = frame.upAt(last.eye);
    EXPECT_NEAR(glm::dot(last.forward(), up), 0, 1e-6);
    EXPECT_NEAR(std::acos(glm::dot(last.forward(), glm::normalize(last.eye - first.eye))), 0.6, 0.02);
  }
}

TEST(CameraFrames, AreLiftedToTheClearanceAndFlownOnSkippingTheBeginning) {
  const auto track = parseCameraFrames(frames(61), "a.frames");
  const proto::FrameTransform frame(planarFrame());
  const TrackOptions options{.from_s = 1, .clearance_m = 500};
  const auto plan = planTrack(*track, frame, kShape, options);
  ASSERT_TRUE(plan.ok());
  EXPECT_NEAR(plan->positions.front().x, 600, 0.01);
  const auto path = pathOverGround(*plan, frame, std::vector<float>(plan->positions.size(), 100), options);
  ASSERT_TRUE(path.ok());
  EXPECT_EQ(path->lifted, plan->positions.size());
  for (const proto::Pose& pose : path->path.poses) EXPECT_GE(frame.toLattice(pose.eye).height_m, 600 - 1e-6);
  EXPECT_FALSE(planTrack(*track, frame, kShape, {.from_s = 2}).ok());
}

TEST(CameraFrames, OfTheRealFlyThroughAreRead) {
  FORELAND_DATA_OR_SKIP(path, "tracks/gcanyon_4k2k_fly4.edited.frames");
  const auto track = readTrack(path);
  ASSERT_TRUE(track.ok()) << track.error().message;
  EXPECT_EQ(track->cameras.size(), 2634u);
  EXPECT_EQ(track->skipped, 0u);
}

}  // namespace
}  // namespace foreland::client
