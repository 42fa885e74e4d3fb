// Laws of the swept camera over random terrains and random motions. The reference evaluates both triangulations of
// every cell of its own array of heights, closely spaced along the path.
#include "client/ground/sweep.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <random>
#include <vector>

#include "proto/imagery/relief_codec.h"
#include "tests/support/seed.h"

namespace foreland::test {
namespace {

using client::GroundHeights;
using proto::kTileGutter, proto::kTilePayload, proto::kTileSide;

constexpr double kClearance_m = 2, kStep_m = 0.5, kSpacing_m = 10;
constexpr uint32_t kSide = 300;  // samples: two tiles along each side

struct World {
  proto::FrameTransform frame;
  proto::TileLayer layer;
  std::vector<int32_t> steps;  // kSide * kSide
  GroundHeights ground;

  double stepAt(int64_t x, int64_t y) const {
    const auto in = [](int64_t i) { return static_cast<size_t>(std::clamp<int64_t>(i, 0, kSide - 1)); };
    return kStep_m * steps[in(y)*kSide + in(x)];
  }
  // The higher one of both triangulations. Beyond the data there is no ground.
  double truth(double x, double y) const {
    const double border = 1e-5, end = kSide - 1 - border;
    if (!(x >= border && y >= border && x <= end && y <= end)) return -1e9;
    const auto i = static_cast<int64_t>(x), j = static_cast<int64_t>(y);
    const double u = x - static_cast<double>(i), v = y - static_cast<double>(j);
    const double a = stepAt(i, j), b = stepAt(i + 1, j), c = stepAt(i, j + 1), d = stepAt(i + 1, j + 1);
    const double one = u > v ? a + u * (b - a) + v * (d - b) : a + v * (c - a) + u * (d - c);
    const double other = u + v < 1 ? a + u * (b - a) + v * (c - a) : d + (1 - u) * (c - d) + (1 - v) * (b - d);
    return std::max(one, other);
  }
  double above(const glm::dvec3& eye) const {
    const proto::LatticePosition p = frame.toLattice(eye);
    return p.height_m - truth(p.x, p.y);
  }
};

proto::Frame planar() {
  proto::Frame frame;
  frame.axis_x_m = {kSpacing_m, 0};
  frame.axis_y_m = {0.2, kSpacing_m};  // askew
  frame.anchor = {150, 150};
  return frame;
}
proto::Frame geographic() {
  proto::Frame frame;
  frame.kind = proto::FrameKind::kGeographic;
  frame.latitude0_rad = 0.8, frame.longitude0_rad = 0.1;
  frame.latitude_step_rad = frame.longitude_step_rad = kSpacing_m / 6.37e6;
  frame.origin = {.latitude_rad = 0.8 + 150 * frame.latitude_step_rad,
                  .longitude_rad = 0.1 + 150 * frame.longitude_step_rad};
  return frame;
}

// Hills, cliffs and pillars.
std::vector<int32_t> randomSteps(std::mt19937& random) {
  std::uniform_real_distribution<double> unit(0, 1);
  const double hill = 400 * unit(random), wave = 0.02 + 0.2 * unit(random), noise = 40 * unit(random) * unit(random);
  const double cliff = unit(random) < 0.5 ? 0 : 600 * unit(random);
  std::vector<int32_t> out(size_t{kSide} * kSide);
  for (uint32_t y = 0; y < kSide; ++y)
    for (uint32_t x = 0; x < kSide; ++x) {
      double h = hill * std::sin(wave * x + 0.7) * std::cos(0.8 * wave * y) + noise * unit(random);
      if (x > 120 && x < 180) h += cliff;
      if (random() % 997 == 0) h += 300;
      out[size_t{y} * kSide + x] = static_cast<int32_t>(std::lround(h / kStep_m));
    }
  return out;
}

std::vector<int32_t> tileOf(const World& world, uint32_t tile_x, uint32_t tile_y) {
  std::vector<int32_t> out(size_t{kTileSide} * kTileSide);
  for (uint32_t y = 0; y < kTileSide; ++y)
    for (uint32_t x = 0; x < kTileSide; ++x)
      out[size_t{y} * kTileSide + x] =
          static_cast<int32_t>(world.stepAt(int64_t{tile_x} * kTilePayload + x - kTileGutter,
                                            int64_t{tile_y} * kTilePayload + y - kTileGutter) /
                               kStep_m);
  return out;
}

World makeWorld(std::mt19937& random, const proto::Frame& frame) {
  World world{proto::FrameTransform(frame), {}, randomSteps(random), {}};
  world.layer.width = world.layer.height = kSide;
  world.layer.origin = {-0.5, -0.5};
  world.layer.step_m = kStep_m;
  world.ground.enter(world.layer);
  for (uint32_t y : {0u, 1u})
    for (uint32_t x : {0u, 1u}) world.ground.add({0, 0, x, y}, tileOf(world, x, y));
  return world;
}

glm::dvec3 placeAbove(const World& world, std::mt19937& random, double above_m) {
  std::uniform_real_distribution<double> inside(5, kSide - 6);
  const double x = inside(random), y = inside(random);
  return world.frame.toScene(proto::LatticePosition{x, y, world.truth(x, y) + kClearance_m + kStep_m + above_m});
}

glm::dvec3 randomMotion(std::mt19937& random, double longest_m) {
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> unit(0, 1);
  glm::dvec3 d(normal(random), normal(random), unit(random) < 0.2 ? 0 : normal(random));
  if (unit(random) < 0.1) d.x = d.y = 0;
  return glm::normalize(d + glm::dvec3(0, 0, 1e-9)) * (longest_m * unit(random) * unit(random));
}

class Sweep : public testing::TestWithParam<bool> {
 protected:
  std::mt19937 random_{static_cast<uint32_t>(randomSeed())};
  proto::Frame frame() const { return GetParam() ? geographic() : planar(); }
};

// Motions of a part of the way end on the path of the whole one, so they show all of it.
TEST_P(Sweep, KeepsItsClearanceAlongTheWholeOfEveryPath) {
  uint32_t touched = 0;
  for (int terrain = 0; terrain < 6; ++terrain) {
    const World world = makeWorld(random_, frame());
    glm::dvec3 eye = placeAbove(world, random_, 5);
    for (int i = 0; i < 60; ++i) {
      const glm::dvec3 motion = randomMotion(random_, i % 3 == 0 ? 1500 : 60);
      for (double t = 0.02; t <= 1; t += 0.02) {
        const glm::dvec3 at = client::sweep(world.ground, world.frame, eye, eye + t * motion, kClearance_m);
        ASSERT_GE(world.above(at), kClearance_m - 0.02) << "terrain " << terrain << " motion " << i << " at " << t;
        ASSERT_LE(glm::distance(eye, at), t * glm::length(motion) * 1.0001 + 1e-6);
        touched += at != eye + t * motion ? 1 : 0;
      }
      eye = client::sweep(world.ground, world.frame, eye, eye + motion, kClearance_m);
    }
  }
  EXPECT_GT(touched, 200u);
}

TEST_P(Sweep, DoesNotChangeAMotionThatStaysAboveTheGround) {
  const World world = makeWorld(random_, frame());
  uint32_t free = 0;
  for (int i = 0; i < 500; ++i) {
    const glm::dvec3 eye = placeAbove(world, random_, 30), end = eye + randomMotion(random_, 400);
    double lowest = 1e9, highest = -1e9;
    for (double t = 0; t <= 1; t += 1.0 / 8192) {
      const double above_m = world.above(eye + t * (end - eye));
      lowest = std::min(lowest, above_m), highest = std::max(highest, above_m);
    }
    const glm::dvec3 at = client::sweep(world.ground, world.frame, eye, end, kClearance_m);
    // Relief goes on for half a sample interval beyond the data.
    const bool stays_inside = highest < 1e8;
    if (stays_inside && lowest > kClearance_m + kStep_m + 2) {
      ++free;
      ASSERT_EQ(at, end);
    }
    if (lowest < kClearance_m) { ASSERT_NE(at, end); }
  }
  EXPECT_GT(free, 50u);
}

// Other heights, none, or higher ones than the eye: without a motion there is none.
TEST_P(Sweep, NeverMovesAnEyeThatRests) {
  for (int i = 0; i < 5; ++i) {
    World world = makeWorld(random_, frame());
    const glm::dvec3 eye = placeAbove(world, random_, -200 + 100 * i);
    EXPECT_EQ(client::sweep(world.ground, world.frame, eye, eye, kClearance_m), eye);
    world.ground.keep({});
    EXPECT_EQ(client::sweep(world.ground, world.frame, eye, eye, kClearance_m), eye);
  }
}

// Under ground that has become known: every motion sideways lifts it by at most its own length, until it is free, and
// none takes it deeper.
TEST_P(Sweep, FreesAnEyeThatIsTooLowByItsOwnMotion) {
  for (int i = 0; i < 40; ++i) {
    const World world = makeWorld(random_, frame());
    glm::dvec3 eye = placeAbove(world, random_, -30);
    double missing_m = kClearance_m - world.above(eye), way_m = 0;
    for (int k = 0; k < 400 && missing_m > 0; ++k) {
      const glm::dvec3 motion = randomMotion(random_, 3);
      const glm::dvec3 at = client::sweep(world.ground, world.frame, eye, eye + motion, kClearance_m);
      ASSERT_LE(glm::distance(at, eye), 2 * glm::length(motion) + 1e-6) << "it jumps";
      const double now_m = kClearance_m - world.above(at);
      ASSERT_LE(now_m, std::max(missing_m, 0.0) + kStep_m + 1e-3) << "it sinks";
      missing_m = now_m, eye = at, way_m += glm::length(motion);
    }
    EXPECT_LE(missing_m, 0.02) << "after " << way_m << " m";
  }
}

// At any speed: what is a sample wide and stands in the way is climbed, which takes as long as it is high.
TEST_P(Sweep, DoesNotPassThroughAThinWall) {
  World world = makeWorld(random_, frame());
  for (uint32_t y = 0; y < kSide; ++y)
    for (uint32_t x = 0; x < kSide; ++x) world.steps[size_t{y} * kSide + x] = x == 150 ? 2000 : 0;
  for (uint32_t y : {0u, 1u})
    for (uint32_t x : {0u, 1u}) world.ground.add({0, 0, x, y}, tileOf(world, x, y));
  const glm::dvec3 eye = world.frame.toScene(proto::LatticePosition{140, 100, 50}),
                   end = world.frame.toScene(proto::LatticePosition{180, 100, 50});
  const glm::dvec3 at = client::sweep(world.ground, world.frame, eye, end, kClearance_m);
  EXPECT_LT(world.frame.toLattice(at).x, 150);
  EXPECT_GE(world.above(at), kClearance_m - 0.02);
}

INSTANTIATE_TEST_SUITE_P(Frames, Sweep, testing::Bool(),
                         [](const auto& p) { return p.param ? "Geographic" : "Planar"; });

// Coarse tiles where there are no fine ones, and exact heights before either.
TEST(GroundHeights, AreTheFinestThatAreKnown) {
  std::mt19937 random(static_cast<uint32_t>(randomSeed()));
  World world = makeWorld(random, planar());
  const glm::dvec2 at(40.3, 60.8);
  const auto bilinear = [&] {
    const double u = 0.3, v = 0.8;
    return (world.stepAt(40, 60) * (1 - u) + world.stepAt(41, 60) * u) * (1 - v) +
           (world.stepAt(40, 61) * (1 - u) + world.stepAt(41, 61) * u) * v;
  };
  ASSERT_TRUE(world.ground.heightAt(at));
  EXPECT_NEAR(*world.ground.heightAt(at), bilinear(), 1e-9);
  world.ground.keep({});
  EXPECT_FALSE(world.ground.heightAt(at));
  world.ground.setMesh({.low = {30, 50}, .spacing = 10, .columns = 3, .heights_m = std::vector<float>(9, 7.f)});
  EXPECT_EQ(world.ground.heightAt(at), 7);
  std::vector<int32_t> coarse(proto::kTileTexels, 5);
  world.ground.add({0, 1, 0, 0}, coarse);
  EXPECT_EQ(world.ground.heightAt(at), 5 * 2 * kStep_m);
  world.ground.setExact({.low = {40, 60}, .columns = 2, .heights_m = {1, 2, 3, 4}});
  EXPECT_NEAR(*world.ground.heightAt(at), 1 + 0.3 + 2 * 0.8, 1e-6);
  EXPECT_EQ(world.ground.heightAt({41.5, 60.8}), 5 * 2 * kStep_m);
}

}  // namespace
}  // namespace foreland::test
