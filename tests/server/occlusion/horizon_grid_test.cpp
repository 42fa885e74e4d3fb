// The lines of a horizon's grid lie nowhere above the terrain, and on it where no sample is left out.
#include "server/occlusion/horizon_grid.h"

#include <gtest/gtest.h>

#include "tests/server/occlusion/height_field.h"
#include "tests/support/scene.h"

namespace foreland::server {
namespace {

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
      const auto vertex = static_cast<size_t>(at);
      const float* const heights = level.line(along, line);
      const double height =
          heights[vertex] + (at - static_cast<double>(vertex)) * (heights[vertex + 1] - heights[vertex]);
      const double x = samples * (along == HorizonGrid::Along::kX ? at : line),
                   y = samples * (along == HorizonGrid::Along::kX ? line : at), clearance = field.at(x, y) - height;
      ASSERT_GT(clearance, -1e-3) << "level " << l << " at " << x << " " << y;
      const bool leaves_none_out = l == 0 && grid.stepsOfSample() == 1;
      ASSERT_TRUE(!leaves_none_out || clearance < 1e-3) << x << " " << y;
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

}  // namespace
}  // namespace foreland::server
