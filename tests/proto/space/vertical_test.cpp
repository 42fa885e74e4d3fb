#include "proto/space/vertical.h"

#include <gtest/gtest.h>

#include <cmath>

#include "base/rng.h"
#include "tests/support/seed.h"

namespace foreland::proto {
namespace {

UndulationGrid gridOf(uint32_t columns, uint32_t rows, const auto& undulation) {
  UndulationGrid grid{{-3, 5}, {7, 2.5}, columns, rows, {}, 0};
  for (uint32_t row = 0; row < rows; ++row)
    for (uint32_t column = 0; column < columns; ++column) {
      const glm::dvec2 p = grid.first + glm::dvec2(column, row) * grid.step;
      grid.metres.push_back(static_cast<float>(undulation(p.x, p.y)));
    }
  return grid;
}

double bowl(double x, double y) { return 40 + 0.02 * x - 0.01 * y + 5 * std::sin(0.05 * x) * std::cos(0.08 * y); }

glm::dvec2 somewhere(Rng& rng, const UndulationGrid& grid) {
  return grid.first + glm::dvec2(rng.uniform() * (grid.columns - 1.0), rng.uniform() * (grid.rows - 1.0)) * grid.step;
}

TEST(UndulationGrid, IsExactForWhatIsBilinear) {
  const auto plane = [](double x, double y) { return 48 + 0.25 * x - 0.5 * y + 0.125 * x * y; };
  const UndulationGrid grid = gridOf(5, 4, plane);
  Rng rng(test::randomSeed());
  for (int i = 0; i < 1000; ++i) {
    const glm::dvec2 p = somewhere(rng, grid);
    ASSERT_NEAR(grid.at(p), plane(p.x, p.y), 1e-4);
  }
}

TEST(UndulationGrid, IsAsAtItsBorderBeyondIt) {
  const UndulationGrid grid = gridOf(5, 4, bowl);
  EXPECT_EQ(grid.at({-1000, 6}), grid.at({grid.first.x, 6}));
  EXPECT_EQ(grid.at({4, 1e9}), grid.at({4, grid.first.y + 3 * grid.step.y}));
  EXPECT_TRUE(std::isfinite(grid.at({std::nan(""), 0})));
}

TEST(UndulationGrid, ThinnedIsOffByNoMoreThanItSays) {
  Rng rng(test::randomSeed());
  for (const auto& [columns, rows] : {std::pair(100u, 61u), std::pair(34u, 5u), std::pair(65u, 65u)}) {
    const UndulationGrid grid = gridOf(columns, rows, bowl), thin = thinned(grid, 33);
    EXPECT_LE(thin.columns, 33u);
    EXPECT_LE(thin.rows, 33u);
    ASSERT_TRUE(thin.validate().ok());
    double largest_m = 0;
    for (int i = 0; i < 20000; ++i) {
      const glm::dvec2 p = somewhere(rng, grid);
      largest_m = std::max(largest_m, std::fabs(thin.at(p) - grid.at(p)));
    }
    EXPECT_LE(largest_m, thin.max_error_m + 1e-5);
    EXPECT_GT(largest_m, 0.3 * thin.max_error_m) << "the bound is not empty";
  }
}

TEST(UndulationGrid, ThatIsSmallEnoughStaysAsItIs) {
  const UndulationGrid grid = gridOf(33, 20, bowl);
  EXPECT_EQ(thinned(grid, 33).metres, grid.metres);
}

TEST(UndulationGrid, ThatIsDamagedIsRefused) {
  const UndulationGrid good = gridOf(3, 3, bowl);
  EXPECT_TRUE(good.validate().ok());
  EXPECT_TRUE(UndulationGrid{}.validate().ok());
  const auto expectRefused = [&](const auto& damage) {
    UndulationGrid bad = good;
    damage(bad);
    EXPECT_FALSE(bad.validate().ok());
  };
  expectRefused([](UndulationGrid& g) { g.columns = 4; });
  expectRefused([](UndulationGrid& g) { g.rows = 0; });
  expectRefused([](UndulationGrid& g) { g.step.x = 0; });
  expectRefused([](UndulationGrid& g) { g.first.y = std::nan(""); });
  expectRefused([](UndulationGrid& g) { g.metres[4] = std::nanf(""); });
  expectRefused([](UndulationGrid& g) { g.max_error_m = -1; });
}

TEST(BothHeights, DifferByTheUndulationWhicheverIsStated) {
  VerticalDatum datum{ZeroSurface::kGeoid, "EGM96", "EGM96", gridOf(5, 4, bowl)};
  const glm::dvec2 p(10, 8);
  const auto by_sea = bothHeights(datum, p, 1000);
  ASSERT_TRUE(by_sea);
  EXPECT_EQ(by_sea->above_sea_m, 1000);
  EXPECT_NEAR(by_sea->above_ellipsoid_m, 1000 + bowl(10, 8), 0.5);
  datum.zero_surface = ZeroSurface::kEllipsoid;
  const auto by_ellipsoid = bothHeights(datum, p, by_sea->above_ellipsoid_m);
  ASSERT_TRUE(by_ellipsoid);
  EXPECT_NEAR(by_ellipsoid->above_sea_m, 1000, 1e-9);
}

TEST(BothHeights, AreNotKnownWithoutADatumOrAGeoid) {
  EXPECT_FALSE(bothHeights({}, {0, 0}, 1));
  EXPECT_FALSE(bothHeights({ZeroSurface::kGeoid, "NAVD88 height", {}, {}}, {0, 0}, 1));
}

TEST(VerticalDatum, HasANameIfItIsStated) {
  EXPECT_TRUE(VerticalDatum{}.validate().ok());
  EXPECT_TRUE((VerticalDatum{ZeroSurface::kEllipsoid, "ellipsoid", {}, {}}.validate().ok()));
  EXPECT_FALSE((VerticalDatum{ZeroSurface::kEllipsoid, {}, {}, {}}.validate().ok()));
  EXPECT_FALSE((VerticalDatum{ZeroSurface::kGeoid, "EGM96", "EGM96", {}}.validate().ok()));
}

}  // namespace
}  // namespace foreland::proto
