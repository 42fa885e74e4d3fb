// Tours over a globe: paths of direction and height apart, above the ground, whose keyframes have small regions.
#include "server/view/globe_tour.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "base/rng.h"
#include "proto/space/direction.h"
#include "server/view/ground.h"
#include "server/view/tour.h"
#include "tests/support/globe_scene.h"
#include "tests/support/seed.h"

namespace foreland::server {
namespace {

constexpr std::array<const char*, 10> kGlobeTours{
    "survey", "canyon",       "spin",   "orbit",  "descent", "descent:46.2,-122.19",
    "pole",   "antimeridian", "corner", "equator"};

glm::dvec3 randomDirection(Rng& rng) {
  glm::dvec3 v(2);
  while (glm::length(v) > 1 || glm::length(v) < 0.1) v = {rng.uniform(-1, 1), rng.uniform(-1, 1), rng.uniform(-1, 1)};
  return glm::normalize(v);
}

TEST(GlobeTour, StaysAboveTheGround) {
  for (const uint32_t sparse_levels : {0u, 5u}) {
    const auto scene = test::makeGlobeScene(7, 11, sparse_levels);
    for (const char* name : kGlobeTours) {
      const auto path = planTour(*scene, name, 60);
      ASSERT_TRUE(path.ok()) << name;
      ASSERT_TRUE(path->validate().ok()) << name;
      for (Time t; t < path->end(); t = t + Duration::milliseconds(20))
        ASSERT_GT(heightAboveGround(*scene, path->at(t).eye), 0) << name << " at " << t.toSeconds();
    }
  }
}

// Between the poses of a path, too, where the eye goes along a curve through space.
TEST(GlobeTour, GoesATenthOfItsHeightBetweenKeyframes) {
  const auto scene = test::makeGlobeScene(7, 12);
  const Duration keyframe = Duration::milliseconds(200);
  for (const char* name : {"descent", "descent:-33,151", "pole", "antimeridian", "corner", "equator"}) {
    const auto path = planTour(*scene, name, 60).value();
    for (Time t; t + keyframe < path.end(); t = t + Duration::milliseconds(70)) {
      const glm::dvec3 eye = path.at(t + keyframe).eye;
      // Of the ground's slopes, too, where the height follows them.
      EXPECT_LE(glm::distance(path.at(t).eye, eye), 0.1 * heightAboveGround(*scene, eye) + 2)
          << name << " at " << t.toSeconds();
    }
  }
}

TEST(GlobeTour, DescendsByTheLogarithmOfTheHeight) {
  const auto scene = test::makeGlobeScene(7, 13);
  const proto::FrameTransform transform(scene->frame());
  const auto path = planTour(*scene, "descent:46.2,-122.19", 60).value();
  const proto::Geodetic goal = transform.toGeodetic(path.poses.back().eye);
  EXPECT_NEAR(goal.latitude_rad * 57.29577951, 46.2, 1e-6);
  EXPECT_NEAR(goal.longitude_rad * 57.29577951, -122.19, 1e-6);
  EXPECT_NEAR(heightAboveGround(*scene, path.poses.back().eye), 60, 1e-3);
  const double first = heightAboveGround(*scene, path.poses.front().eye);
  EXPECT_NEAR(first / scene->frame().semi_major_m, 6.283, 0.1);
  const double step = std::log(60 / first) / static_cast<double>(path.poses.size() - 1);
  for (size_t i = 1; i < path.poses.size(); ++i)
    ASSERT_NEAR(std::log(heightAboveGround(*scene, path.poses[i].eye) / first), step * static_cast<double>(i), 1e-6);
}

// The finest samples of a sparse globe are around a corner and a pole (globe_scene.h).
TEST(GlobeTour, DescendsToTheFinestSamples) {
  const auto scene = test::makeGlobeScene(7, 14, 5);
  const auto path = planTour(*scene, "descent", 60).value();
  const proto::LatticePosition at = proto::FrameTransform(scene->frame()).toLattice(path.poses.back().eye);
  const auto& grid = scene->grid();
  const proto::NodeId n =
      proto::NodeId::at(static_cast<uint32_t>(std::lround(at.x)), static_cast<uint32_t>(std::lround(at.y)));
  int finest = 0;
  for (const proto::PageBlock& block : scene->pages().blocks()) finest = std::max(finest, block.level());
  EXPECT_EQ(grid.level(n), finest) << at.x << ", " << at.y;
  EXPECT_TRUE(scene->pages().hasPage(grid.slot(n)));
}

TEST(GlobeTour, NearsItsGoalInDirectionAsInHeight) {
  Rng rng(test::randomSeed());
  for (int i = 0; i < 200; ++i) {
    const Station a{randomDirection(rng), std::exp(rng.uniform(0, 18))},
        b{randomDirection(rng), std::exp(rng.uniform(0, 18))};
    EXPECT_LT(proto::angleOf(between(a, b, 0).direction, a.direction), 1e-7);
    EXPECT_LT(proto::angleOf(between(a, b, 1).direction, b.direction), 1e-7);
    const double share = rng.uniform(0, 1), whole = proto::angleOf(a.direction, b.direction);
    const Station at = between(a, b, share);
    EXPECT_NEAR(std::log(at.above_m), std::lerp(std::log(a.above_m), std::log(b.above_m), share), 1e-9);
    const double way = proto::angleOf(a.direction, at.direction), rest = proto::angleOf(at.direction, b.direction);
    EXPECT_NEAR(way + rest, whole, 1e-6);  // on the great circle
    EXPECT_NEAR(way * (a.above_m - b.above_m), whole * (a.above_m - at.above_m),
                1e-6 * whole * (a.above_m + b.above_m));
  }
}

TEST(GlobeTour, HasOtherNamesThanToursOfPlanes) {
  const auto globe = test::makeGlobeScene(6, 15);
  EXPECT_TRUE(checkTour(*globe, "descent").ok());
  for (const char* name :
       {"descent:", "descent:46", "descent:91,0", "descent:a,b", "descent:1,2,3", "descent:nan,0", "jumps"})
    EXPECT_FALSE(checkTour(*globe, name).ok()) << name;
  test::FormulaSource source(40, 40, [](uint32_t x, uint32_t) { return x; });
  const auto plane = test::makeScene(source);
  EXPECT_TRUE(checkTour(*plane, "orbit").ok());
  for (const char* name : {"descent", "equator", "descent:1,2", "jumps"})
    EXPECT_FALSE(checkTour(*plane, name).ok()) << name;
}

}  // namespace
}  // namespace foreland::server
