// What is derived of a globe's ground about a viewer holds against all of its finest triangles, which are found by the
// judge's own faces and stand where GeographicLib says: squares hold their ground, horizons lie below it with room to
// spare, and of what is called hidden nothing can be seen, by rays on these triangles, from anywhere in the region.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>
#include <optional>

#include "server/occlusion/viewer_occlusion.h"
#include "tests/support/globe_scene.h"
#include "tests/support/plain_planet.h"
#include "tests/support/seed.h"
#include "tests/support/wanderer.h"

namespace foreland::server {
namespace {

using proto::BlockId;
using test::Corners;
using test::distanceTo;

// A planet of ridges, whole or fine about a corner and a pole alone.
struct Planet {
  std::shared_ptr<const terrain::Scene> scene;
  Hierarchy hierarchy;
  std::shared_ptr<const SceneOcclusion> shared;
  test::PlainPlanet plain;

  Planet(uint64_t seed, uint32_t sparse_levels)
      : scene(test::makeGlobeScene(
            8, [seed](const glm::dvec3& direction) { return test::globeRidges(seed, direction); }, sparse_levels)),
        hierarchy(scene),
        shared(SceneOcclusion::create(hierarchy).value()),
        plain(*scene) {}

  uint32_t side() const { return hierarchy.grid().rootSize(); }
  // Of a vertex on a face's square, on the ground.
  glm::dvec3 at(uint32_t face, uint32_t x, uint32_t y) const {
    return plain.at(face, {x, y}, plain.heightMetres(face, {x, y}));
  }
  // About one of the places where a sparse planet is fine.
  glm::dvec3 anywhere(Rng& rng) const {
    const uint32_t face = rng.below(2) == 0 ? 0 : 2, middle = face == 0 ? 1 : side() / 2 + 1;
    const auto near = [&] {
      return static_cast<uint32_t>(std::clamp<int64_t>(middle + int64_t(rng.below(60)) - 30, 0, side()));
    };
    const uint32_t x = near(), y = near();
    return at(face, x, y);
  }
  std::vector<Corners> near(const glm::dvec3& point, double metres) const {
    std::vector<Corners> found;
    for (const Corners& t : plain.triangles())
      if (glm::distance(t[0], point) < metres + glm::distance(t[0], t[1]) + glm::distance(t[0], t[2]))
        found.push_back(t);
    return found;
  }
  // A vertex of a square of a face; not always one that is there.
  std::optional<glm::dvec3> vertexIn(uint32_t face, int64_t x, int64_t y, uint32_t side, Rng& rng) const {
    for (int i = 0; i < 10; ++i) {
      const auto vx = static_cast<uint32_t>(x + int64_t(rng.below(side + 1))),
                 vy = static_cast<uint32_t>(y + int64_t(rng.below(side + 1)));
      if (plain.isThere(face, {vx, vy})) return at(face, vx, vy);
    }
    return std::nullopt;
  }
};

glm::dvec3 within(const Corners& t, Rng& rng) {
  double a = rng.uniform(0, 1), b = rng.uniform(0, 1);
  if (a + b > 1) a = 1 - a, b = 1 - b;
  return t[0] + a * (t[1] - t[0]) + b * (t[2] - t[0]);
}

class GlobeGround : public testing::TestWithParam<uint32_t> {};

TEST_P(GlobeGround, SquaresHoldIt) {
  const uint64_t seed = test::randomSeed();
  Rng rng(seed);
  const Planet planet(seed, GetParam());
  const GlobeSquares& squares = planet.shared->globe->squares;
  double largest = 0;
  for (int i = 0; i < 20'000; ++i) {
    const auto scale = static_cast<uint32_t>(rng.below(7));
    const uint32_t side = 2u << scale, face = static_cast<uint32_t>(rng.below(6)),
                   x = static_cast<uint32_t>(rng.below(planet.side() / side)),
                   y = static_cast<uint32_t>(rng.below(planet.side() / side));
    const auto hull = squares.hullOf(scale, face * (planet.side() / side) + x, y);
    ASSERT_TRUE(hull);
    const uint32_t vx = x * side + static_cast<uint32_t>(rng.below(side + 1)),
                   vy = y * side + static_cast<uint32_t>(rng.below(side + 1));
    if (!planet.plain.isThere(face, {vx, vy})) continue;
    const auto& c = hull->corners;
    const glm::dvec3 p = planet.at(face, vx, vy);
    const double off = std::min({distanceTo({c[0], c[1], c[3]}, p), distanceTo({c[0], c[3], c[2]}, p),
                                 distanceTo({c[0], c[1], c[2]}, p), distanceTo({c[1], c[3], c[2]}, p)});
    ASSERT_LE(off, hull->error_m + 1e-5) << "seed " << seed << ": " << scale << ' ' << face << ' ' << vx << ' ' << vy;
    largest = std::max(largest, off);
  }
  EXPECT_GT(largest, 20) << "they are not idle";
}

// All ground within a spacing of a point of a line.
TEST_P(GlobeGround, HorizonsLieBelowItWithRoom) {
  const uint64_t seed = test::randomSeed();
  Rng rng(seed);
  const Planet planet(seed, GetParam());
  double highest = -1e9, gap = 0;
  for (int place = 0; place < 3; ++place) {
    const glm::dvec3 about = planet.anywhere(rng);
    const auto grid = planet.shared->globe->grids.about(about * 1.001, nullptr);
    ASSERT_NE(grid, nullptr);
    const auto ground = planet.near(about, 5'000);
    for (int i = 0; i < 200'000; ++i) {
      const glm::dvec3 p = grid->toAxes(within(ground[rng.below(ground.size())], rng));
      const auto l = static_cast<uint32_t>(rng.below(grid->levels().size()));
      const HorizonGrid::Level& level = grid->levels()[l];
      const double spacing = 1u << l;
      const size_t axis = rng.below(2);
      // On a line along x or y, not farther than a spacing from the ground's place.
      const glm::dvec2 steps = grid->toGrid(glm::dvec2(p)) / spacing;
      const double across = axis == 0 ? steps.y : steps.x, line = std::floor(across) + double(rng.below(2));
      const double reach = std::sqrt(1 - (line - across) * (line - across));
      const double at = (axis == 0 ? steps.x : steps.y) + rng.uniform(-reach, reach);
      if (line < 0 || line >= level.lines[axis] || at < 0 || at >= level.vertices[axis] - 1) continue;
      const uint16_t* heights =
          level.line(axis == 0 ? HorizonGrid::Along::kX : HorizonGrid::Along::kY, static_cast<uint32_t>(line));
      const double z = grid->steps().metres(
          std::lerp(double(heights[size_t(at)]), double(heights[size_t(at) + 1]), at - std::floor(at)));
      ASSERT_LE(z, p.z + 1e-6) << "seed " << seed << ", level " << l;
      highest = std::max(highest, z);
      if (l == 0) gap = std::max(gap, p.z - z);
    }
  }
  EXPECT_GT(highest, 0) << "they are not idle";
  EXPECT_LT(gap, 800);
}

TEST_P(GlobeGround, WhatIsHiddenCannotBeSeenAndMuchIsInValleys) {
  const uint64_t seed = test::randomSeed();
  Rng rng(seed);
  const Planet planet(seed, GetParam());
  BlockTest test{planet.hierarchy, *planet.shared};
  const proto::FrameTransform& transform = planet.hierarchy.frame().transform();
  int hidden = 0, tried = 0, rays = 0;
  for (int view_count = 0; view_count < 14; ++view_count) {
    const glm::dvec3 ground = planet.anywhere(rng), up = transform.upAt(ground),
                     aside(rng.uniform(-30, 30), rng.uniform(-30, 30), rng.uniform(-30, 30));
    const EyeCapsule eyes{ground + rng.uniform(50, 120) * up, aside, rng.uniform(0, 10)};
    const auto grid = planet.shared->globe->grids.about(eyes.eye, nullptr);
    ASSERT_NE(grid, nullptr);
    const Tolerance tolerance{{1.0, 640, 360}, 1};
    Horizon horizon(*grid);
    horizon.look(eyes, Horizon::kBinOfTolerance / tolerance.lens.focalPx());
    const std::vector<Corners> near = planet.near(ground, 7'000);
    const proto::LatticePosition eye_at = transform.toLattice(eyes.eye);
    const uint32_t face = std::min(5u, static_cast<uint32_t>(eye_at.x) / planet.side());
    for (int i = 0; i < 150; ++i) {
      const auto scale = static_cast<uint8_t>(rng.below(4));
      const uint32_t side = BlockId::kSide << scale, blocks = planet.side() / side;
      const auto x = int64_t(std::floor((eye_at.x - face * planet.side() + rng.uniform(-35, 35)) / side)),
                 y = int64_t(std::floor((eye_at.y + rng.uniform(-35, 35)) / side));
      if (x < 0 || y < 0 || x >= blocks || y >= blocks) continue;
      ++tried;
      const BlockId block{scale, static_cast<uint32_t>(face * blocks + x), static_cast<uint32_t>(y)};
      const bool is_at_seam = x == 0 || y == 0 || x + 1 == blocks || y + 1 == blocks;
      if (!test.isBehind(block, tolerance, horizon)) continue;
      ASSERT_FALSE(is_at_seam) << "seed " << seed;
      ++hidden;
      for (int sample = 0; sample < 10; ++sample) {
        // True, or drawn between vertices of the block.
        const auto vertex = [&] { return planet.vertexIn(face, x * side, y * side, side, rng); };
        const auto a = vertex(), b = vertex(), c = vertex();
        if (!a || !b || !c) continue;
        const glm::dvec3 point = within({*a, *b, *c}, rng);
        const glm::dvec3 off(rng.uniform(-1, 1), rng.uniform(-1, 1), rng.uniform(-1, 1));
        const glm::dvec3 eye =
            eyes.eye + rng.uniform(0, 1) * eyes.way + eyes.radius_m * rng.uniform(0, 1) * glm::normalize(off);
        ++rays;
        EXPECT_TRUE(std::ranges::any_of(near,
                                        [&](const Corners& t) {
                                          const auto share = test::meetPlainly(eye, point, t);
                                          return share && *share < 0.999;
                                        }))
            << "seed " << seed << ": block " << int(block.scale) << ' ' << block.x << ' ' << block.y;
      }
    }
  }
  EXPECT_GT(hidden, tried / 20) << "of " << tried << ", " << rays << " rays";
}

INSTANTIATE_TEST_SUITE_P(SparseLevels, GlobeGround, testing::Values(0, 5));

// A viewer goes on with the grid of its place until it is far from it, gets none high above, and no more are held than
// there may be.
TEST(GlobeGrids, AreSharedByPlaceAndBounded) {
  const Planet planet(test::randomSeed(), 0);
  GlobeGrids grids(planet.hierarchy, GlobeGrids::Building::kByTheCaller);
  const glm::dvec3 eye = planet.at(0, 60, 70) * 1.002;
  const auto held = grids.about(eye, nullptr);
  ASSERT_NE(held, nullptr);
  EXPECT_EQ(grids.about(eye, nullptr), held);
  EXPECT_EQ(grids.about(eye + glm::dvec3(0, 400, 0), held), held);
  EXPECT_EQ(grids.about(eye * 1.5, held), nullptr) << "high above";
  EXPECT_EQ(grids.about(eye * 1e4, held), nullptr) << "far away";
  const size_t one = held->bytes();
  std::vector<GlobeGrids::Grid> viewers{held};
  for (uint32_t face = 0; face < 6; ++face)
    for (const uint32_t x : {20, 130, 240}) viewers.push_back(grids.about(planet.at(face, x, 128) * 1.002, nullptr));
  EXPECT_LE(grids.bytes(), GlobeGrids::kMost * 2 * one);
  EXPECT_EQ(std::ranges::count_if(viewers, [](const auto& grid) { return grid != nullptr; }), int{GlobeGrids::kMost});
  viewers.resize(1);
  EXPECT_NE(grids.about(planet.at(3, 10, 10) * 1.002, nullptr), nullptr) << "there is room again";
  EXPECT_EQ(grids.about(eye, nullptr), held) << "what is used stays";
}

}  // namespace
}  // namespace foreland::server
