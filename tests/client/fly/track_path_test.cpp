#include "client/fly/track_path.h"

#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>

#include "tests/client/fly/alpine_tile.h"

namespace foreland::client {
namespace {

// Due north along 8.5 degrees east, 10 m/s (nearly), 2000 m high, a fix a second.
Track northward(double from_latitude_deg, size_t seconds) {
  Track track;
  for (size_t i = 0; i <= seconds; ++i)
    track.fixes.push_back(
        {static_cast<double>(i), (from_latitude_deg + static_cast<double>(i) * 9e-5) * kDeg, 8.5 * kDeg, 2000});
  return track;
}

std::vector<float> flat(const PlannedTrack& plan, float height_m) {
  return std::vector<float>(plan.positions.size(), height_m);
}

TrackPath pathOf(const Track& track, const TrackOptions& options, float ground_m) {
  const proto::FrameTransform frame(alpineFrame());
  const auto plan = planTrack(track, frame, kShape, options);
  EXPECT_TRUE(plan.ok()) << plan.error().message;
  auto path = pathOverGround(*plan, frame, flat(*plan, ground_m), options);
  EXPECT_TRUE(path.ok());
  return std::move(path).value();
}

TEST(TrackPath, FollowsTheTrackAtItsHeightLookingAlongItAndALittleDown) {
  const proto::FrameTransform frame(alpineFrame());
  const TrackPath p = pathOf(northward(46.5, 60), {}, 1000);
  ASSERT_EQ(p.path.poses.size(), 601u);
  EXPECT_EQ(p.path.step, Duration::milliseconds(100));
  for (size_t i = 0; i < p.path.poses.size(); ++i) {
    const proto::Pose& pose = p.path.poses[i];
    const proto::Geodetic at = frame.toGeodetic(pose.eye);
    EXPECT_NEAR(at.latitude_rad, (46.5 + static_cast<double>(i) * 9e-6) * kDeg, 1e-9);
    EXPECT_NEAR(at.height_m, 2000, 1e-3);
    EXPECT_GT(pose.forward().y, 0.97);
    EXPECT_NEAR(pose.forward().x, 0, 1e-3);
    EXPECT_LT(pose.forward().z, -0.1);
    EXPECT_NEAR(glm::dot(pose.right(), frame.upAt(pose.eye)), 0, 1e-6);
  }
  EXPECT_EQ(p.lifted, 0u);
}

TEST(TrackPath, SpeedAndSecondsChooseThePart) {
  const TrackPath p = pathOf(northward(46.5, 600), {.speed = 20, .from_s = 100, .seconds = 10}, 0);
  EXPECT_EQ(p.path.poses.size(), 101u);
  const proto::FrameTransform frame(alpineFrame());
  EXPECT_NEAR(frame.toGeodetic(p.path.poses.front().eye).latitude_rad, (46.5 + 100 * 9e-5) * kDeg, 1e-9);
  EXPECT_NEAR(frame.toGeodetic(p.path.poses.back().eye).latitude_rad, (46.5 + 300 * 9e-5) * kDeg, 1e-9);
}

TEST(TrackPath, LiftsWhatIsUnderTheGroundToTheClearance) {
  const proto::FrameTransform frame(alpineFrame());
  const auto plan = planTrack(northward(46.5, 60), frame, kShape, {});
  std::vector<float> ground = flat(*plan, 500);
  for (size_t i = 300; i < 320; ++i) ground[i] = 2100;  // a wall
  const auto p = pathOverGround(*plan, frame, ground, {.clearance_m = 25});
  ASSERT_TRUE(p.ok());
  EXPECT_EQ(p->lifted, 20u);
  for (size_t i = 0; i < ground.size(); ++i) {
    const double height_m = frame.toGeodetic(p->path.poses[i].eye).height_m;
    EXPECT_GE(height_m, ground[i] + 25 - 1e-6) << i;
    EXPECT_GE(height_m, 2000 - 1e-6);
    if (i + 25 < 300 || i > 345) { EXPECT_NEAR(height_m, 2000, 1e-6) << i; }
    const double before_m = frame.toGeodetic(p->path.poses[i > 0 ? i - 1 : 0].eye).height_m;
    EXPECT_LT(std::fabs(height_m - before_m), 10) << "a jump at " << i;
  }
}

TEST(TrackPath, FliesAboveGroundWhenAsked) {
  const proto::FrameTransform frame(alpineFrame());
  const TrackPath p = pathOf(northward(46.5, 20), {.agl_m = 60}, 777);
  for (const proto::Pose& pose : p.path.poses) EXPECT_NEAR(frame.toGeodetic(pose.eye).height_m, 837, 1e-3);
}

TEST(TrackPath, CutsOffWhatIsOutsideTheDataWithANote) {
  const proto::FrameTransform frame(alpineFrame());
  const auto plan = planTrack(northward(45.99, 600), frame, kShape, {});
  ASSERT_TRUE(plan.ok());
  EXPECT_EQ(plan->notes.size(), 1u);
  for (const glm::dvec2& place : plan->positions) EXPECT_GE(place.y, 0);
  EXPECT_LT(plan->positions.size(), 6000u);
}

TEST(TrackPath, KeepsLongFlightsWithinWhatAPathHolds) {
  const proto::FrameTransform frame(alpineFrame());
  Track track = northward(46.2, 100);
  for (Fix& fix : track.fixes) fix.time_s *= 300;  // 30,000 s
  const auto plan = planTrack(track, frame, kShape, {});
  ASSERT_TRUE(plan.ok());
  EXPECT_LE(plan->positions.size(), proto::Path::kMaxPoses);
  EXPECT_TRUE(pathOverGround(*plan, frame, flat(*plan, 0), {}).ok());
}

TEST(TrackPath, LooksAsBeforeWhereTheFlightStandsStill) {
  Track track = northward(46.5, 30);
  const Fix last = track.fixes.back();
  for (int i = 1; i < 60; ++i)
    track.fixes.push_back({last.time_s + i, last.latitude_rad, last.longitude_rad, last.height_m});
  const TrackPath p = pathOf(track, {}, 0);
  for (const proto::Pose& pose : p.path.poses) EXPECT_GT(pose.forward().y, 0.9);
}

TEST(TrackPath, RefusesAProjectedSceneSayingWhatToDo) {
  const auto plan = planTrack(northward(46.5, 10), proto::FrameTransform(proto::Frame{}), kShape, {});
  ASSERT_FALSE(plan.ok());
  EXPECT_NE(plan.error().message.find("EPSG:4326"), std::string::npos);
}

TEST(TrackPath, RefusesWhatCannotBeFlown) {
  const proto::FrameTransform frame(alpineFrame());
  const Track track = northward(46.5, 10);
  EXPECT_FALSE(planTrack(northward(12, 10), frame, kShape, {}).ok());
  EXPECT_FALSE(planTrack(track, frame, kShape, {.speed = 0}).ok());
  EXPECT_FALSE(planTrack(track, frame, kShape, {.speed = NAN}).ok());
  EXPECT_FALSE(planTrack(track, frame, kShape, {.from_s = 11}).ok());
  EXPECT_FALSE(planTrack(track, frame, kShape, {.seconds = -1}).ok());
  Track no_heights = track;
  no_heights.heights = TrackHeights::kMissing;
  EXPECT_FALSE(planTrack(no_heights, frame, kShape, {}).ok());
  EXPECT_TRUE(planTrack(no_heights, frame, kShape, {.agl_m = 50}).ok());
}

TEST(TrackPath, RefusesGroundHeightsThatDoNotFit) {
  const proto::FrameTransform frame(alpineFrame());
  const auto plan = planTrack(northward(46.5, 10), frame, kShape, {});
  EXPECT_FALSE(pathOverGround(*plan, frame, std::vector<float>(3, 0.f), {}).ok());
  EXPECT_FALSE(pathOverGround(*plan, frame, flat(*plan, NAN), {}).ok());
}

proto::Frame globeFrame() {
  proto::Frame frame;
  frame.kind = proto::FrameKind::kGlobe;
  frame.face_steps = 1u << 17;
  return frame;
}
const proto::GridShape kGlobeShape = proto::GridTopology::cubeShape(17);

// Over the antimeridian, an edge of the cube and a pole, and as far above the sea as recorded.
TEST(TrackPath, KnowsNoSeamOverAGlobe) {
  const proto::FrameTransform frame(globeFrame());
  for (const double longitude : {8.5, 45.0, 180.0, -180.0}) {
    Track track;
    for (size_t i = 0; i <= 60; ++i)
      track.fixes.push_back({static_cast<double>(i), (30 + static_cast<double>(i)) * kDeg, longitude * kDeg, 9000});
    auto plan = planTrack(track, frame, kGlobeShape, {});
    ASSERT_TRUE(plan.ok()) << plan.error().message;
    ASSERT_EQ(plan->positions.size(), 601u);
    plan->undulations_m.assign(plan->positions.size(), 47);
    const auto path = pathOverGround(*plan, frame, flat(*plan, -5000), {});
    ASSERT_TRUE(path.ok()) << path.error().message;
    for (size_t i = 10; i + 10 < path->path.poses.size(); ++i) {
      const proto::Geodetic at = frame.toGeodetic(path->path.poses[i].eye);
      ASSERT_NEAR(at.latitude_rad, (30 + static_cast<double>(i) * 0.1) * kDeg, 1e-4) << longitude << ", " << i;
      ASSERT_NEAR(std::cos(at.longitude_rad - longitude * kDeg), 1, 1e-9) << longitude << ", " << i;
      ASSERT_NEAR(at.height_m, 9047, 1e-3) << longitude << ", " << i;
    }
  }
}

TEST(TrackPath, GoesOnAcrossTheAntimeridian) {
  const proto::FrameTransform frame(globeFrame());
  Track track;
  for (size_t i = 0; i <= 20; ++i) {
    const double longitude = 179.9 + 0.01 * static_cast<double>(i);
    track.fixes.push_back(
        {static_cast<double>(i), -17 * kDeg, (longitude > 180 ? longitude - 360 : longitude) * kDeg, 500});
  }
  const auto plan = planTrack(track, frame, kGlobeShape, {});
  ASSERT_TRUE(plan.ok());
  const auto path = pathOverGround(*plan, frame, flat(*plan, 0), {});
  ASSERT_TRUE(path.ok());
  for (size_t i = 1; i < path->path.poses.size(); ++i)
    ASSERT_LT(glm::distance(path->path.poses[i - 1].eye, path->path.poses[i].eye), 120) << i;
}

TEST(TrackPath, LaysNoCameraOfAnotherModelOnAGlobe) {
  Track track;
  track.cameras = {{.time_s = 0}, {.time_s = 1}};
  const auto plan = planTrack(track, proto::FrameTransform(globeFrame()), kGlobeShape, {});
  ASSERT_FALSE(plan.ok());
  EXPECT_NE(plan.error().message.find("globe"), std::string::npos);
}

}  // namespace
}  // namespace foreland::client
