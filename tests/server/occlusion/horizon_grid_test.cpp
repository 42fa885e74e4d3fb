// The lines of a horizon's grid lie nowhere above the terrain, and on it where no sample is left out.
#include "server/occlusion/horizon/horizon_grid.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/common.hpp>
#include <glm/vector_relational.hpp>

#include "tests/support/height_field.h"
#include "tests/support/scene.h"
#include "tests/support/seed.h"

namespace foreland::server {
namespace {

// In steps, between two vertices of a line.
double heightAt(const uint16_t* heights, double at) {
  const auto vertex = static_cast<size_t>(at);
  return std::lerp(static_cast<double>(heights[vertex]), static_cast<double>(heights[vertex + 1]),
                   at - static_cast<double>(vertex));
}

class Grids : public testing::TestWithParam<size_t> {};

TEST_P(Grids, LieBelowTheTerrain) {
  const auto seed = static_cast<uint64_t>(testing::UnitTest::GetInstance()->random_seed());
  SCOPED_TRACE(testing::Message() << "seed " << seed);
  Rng rng(seed);
  const Hierarchy hierarchy(test::makeScene(129, 97, seed));
  const HorizonGrid grid(hierarchy, GetParam());
  const test::HeightField field(hierarchy);
  for (size_t l = 0; l < grid.levels().size(); ++l) {
    const HorizonGrid::Level& level = grid.levels()[l];
    const double samples = static_cast<double>(1u << l) / grid.stepsOfSample();
    double closest = 1e9;
    for (int i = 0; i < 2000; ++i) {
      const auto along = rng.below(2) ? HorizonGrid::Along::kX : HorizonGrid::Along::kY;
      const auto axis = static_cast<size_t>(along);
      const auto line = static_cast<uint32_t>(rng.below(level.lines[axis]));
      const double at = rng.uniform(0, level.vertices[axis] - 1.001);
      const double height = grid.steps().metres(heightAt(level.line(along, line), at));
      const double x = samples * (along == HorizonGrid::Along::kX ? at : line),
                   y = samples * (along == HorizonGrid::Along::kX ? line : at), clearance = field.at(x, y) - height;
      ASSERT_GT(clearance, -1e-3) << "level " << l << " at " << x << " " << y;
      const bool leaves_none_out = l == 0 && grid.stepsOfSample() == 1;
      ASSERT_TRUE(!leaves_none_out || clearance < grid.steps().step_m + 1e-3) << x << " " << y;
      closest = std::min(closest, clearance);
    }
    EXPECT_LT(closest, 1) << "level " << l;
  }
}

INSTANTIATE_TEST_SUITE_P(Sizes, Grids, testing::Values(size_t{1} << 20, size_t{4000}, size_t{1000}));

TEST(Grid, PlacesTheScenesPositions) {
  test::FormulaSource source(65, 65, [](uint32_t, uint32_t) { return 100.0; });
  source.info().frame.axis_x_m = {7, 2};
  source.info().frame.axis_y_m = {-3, 9};
  const Hierarchy hierarchy(test::makeScene(source));
  const HorizonGrid grid(hierarchy);
  const glm::dvec2 p(hierarchy.frame().position(proto::NodeId::at(13, 40), 0));
  EXPECT_NEAR(grid.toGrid(p).x, 13, 1e-9);
  EXPECT_NEAR(grid.toGrid(p).y, 40, 1e-9);
  double longest = 0;
  for (double angle = 0; angle < 6.3; angle += 0.01) {
    const glm::dvec2 unit(std::cos(angle), std::sin(angle));
    longest = std::max(longest, glm::length(grid.directionToGrid(unit)));
    EXPECT_LE(glm::length(grid.toScene(unit)), grid.metresOfStep() + 1e-9);
    EXPECT_NEAR(glm::length(grid.directionToGrid(grid.toScene(unit)) - unit), 0, 1e-9);
  }
  EXPECT_LE(longest, grid.stepsOfMetre() + 1e-9);
  EXPECT_GT(longest, 0.99 * grid.stepsOfMetre());
}

// Of the earth, of Mars or of the moon.
struct Body {
  double semi_major_m, flattening;
};
Body someBody(Rng& rng) {
  constexpr std::array<Body, 3> kBodies{{{6378137, 1 / 298.257223563}, {3396190, 1 / 169.8}, {1737400, 0}}};
  return kBodies[rng.below(kBodies.size())];
}

// Anywhere between the latitudes that have grids.
std::shared_ptr<const terrain::Scene> geographicScene(uint64_t seed, double step_rad) {
  Rng rng(seed);
  const double a = rng.uniform(5, 9), b = rng.uniform(5, 9);
  const Body body = someBody(rng);
  const double max_m = 900 * body.semi_major_m / 6378137;  // as steep everywhere
  test::FormulaSource source(
      129, 97, [=](uint32_t x, uint32_t y) { return 1500 + max_m * std::sin(x / a) * std::cos(y / b) + 7 * (x % 3); },
      proto::FrameKind::kGeographic);
  proto::Frame& frame = source.info().frame;
  frame.semi_major_m = body.semi_major_m, frame.flattening = body.flattening;
  frame.longitude_step_rad = step_rad, frame.latitude_step_rad = step_rad;
  frame.latitude0_rad = rng.uniform(-1.2, 1.1), frame.longitude0_rad = rng.uniform(-3, 3);
  frame.origin = {frame.latitude0_rad + 48 * step_rad, frame.longitude0_rad + 64 * step_rad, 0};
  return test::makeScene(source);
}

class GeographicGrids : public testing::TestWithParam<double> {};

TEST_P(GeographicGrids, LieBelowTheTerrain) {
  const uint64_t seed = test::randomSeed();
  Rng rng(seed);
  const Hierarchy hierarchy(geographicScene(seed, GetParam()));
  const bool is_fine = rng.below(2) == 0;
  const auto grid = HorizonGrid::of(hierarchy, is_fine ? HorizonGrid::kMaxVertices : 8000);
  ASSERT_NE(grid, nullptr);
  const proto::FrameTransform& frame = hierarchy.frame().transform();
  const test::HeightField field(hierarchy);
  const double sample_m = GetParam() * frame.frame().semi_major_m;
  for (size_t l = 0; l < grid->levels().size(); ++l) {
    const HorizonGrid::Level& level = grid->levels()[l];
    std::vector<double> clearances;
    for (int i = 0; i < 4000; ++i) {
      const auto axis = static_cast<size_t>(rng.below(2));
      const auto line = static_cast<uint32_t>(rng.below(level.lines[axis]));
      const double at = rng.uniform(0, level.vertices[axis] - 1.001);
      const double z = grid->steps().metres(
          heightAt(level.line(axis == 0 ? HorizonGrid::Along::kX : HorizonGrid::Along::kY, line), at));
      const glm::dvec2 steps = double(1u << l) * (axis == 0 ? glm::dvec2(at, line) : glm::dvec2(line, at));
      const glm::dvec2 position = grid->toScene(steps - grid->toGrid(glm::dvec2(0)));
      const proto::LatticePosition p = frame.toLattice({position.x, position.y, z});
      ASSERT_TRUE(p.x >= -0.01 && p.y >= -0.01 && p.x <= 128.01 && p.y <= 96.01) << p.x << ", " << p.y;
      clearances.push_back(field.at(std::clamp(p.x, 0.0, 127.999), std::clamp(p.y, 0.0, 95.999)) - p.height_m);
      ASSERT_GT(clearances.back(), -1e-3) << "level " << l << " at " << p.x << ", " << p.y;
    }
    std::sort(clearances.begin(), clearances.end());
    // As the slopes rise in half a sample or so.
    if (l == 0 && is_fine) { EXPECT_LT(clearances[clearances.size() / 2], 20 + 0.3 * sample_m); }
  }
}

TEST_P(GeographicGrids, BoundsHoldTheGround) {
  const uint64_t seed = test::randomSeed();
  Rng rng(seed);
  const Hierarchy hierarchy(geographicScene(seed, GetParam()));
  const auto grid = HorizonGrid::of(hierarchy);
  ASSERT_NE(grid, nullptr);
  for (int i = 0; i < 200; ++i) {
    const glm::dvec2 low(rng.uniform(0, 127), rng.uniform(0, 95)), size(rng.uniform(0, 60), rng.uniform(0, 60));
    const proto::LatticeBox box{low, glm::min(low + size, glm::dvec2(128, 96))};
    const double lowest_m = rng.uniform(-100, 2000), highest_m = lowest_m + rng.uniform(0, 2000);
    const HorizonGrid::Bounds bounds = grid->boundsOf(box, lowest_m, highest_m);
    for (int k = 0; k < 50; ++k) {
      const proto::LatticePosition p{rng.uniform(box.low.x, box.high.x), rng.uniform(box.low.y, box.high.y),
                                     rng.uniform(lowest_m, highest_m)};
      const glm::dvec3 at = hierarchy.frame().transform().toScene(p);
      const glm::dvec2 steps = grid->toGrid(glm::dvec2(at));
      EXPECT_TRUE(glm::all(glm::greaterThanEqual(steps, bounds.low)) &&
                  glm::all(glm::lessThanEqual(steps, bounds.high)));
      EXPECT_LE(at.z, bounds.top_m);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Steps, GeographicGrids, testing::Values(1.5e-5, 3e-4));

TEST(GeographicGrid, IsNotOfMuchOfTheEarth) {
  EXPECT_EQ(HorizonGrid::of(Hierarchy(geographicScene(1, 2e-3))), nullptr);
}

}  // namespace
}  // namespace foreland::server
