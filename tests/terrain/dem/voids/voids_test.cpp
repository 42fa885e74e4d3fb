#include "terrain/dem/voids/voids.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <vector>

#include "base/rng.h"
#include "terrain/elevation_source.h"
#include "tests/support/seed.h"

namespace foreland::terrain {
namespace {

struct Grid {
  uint32_t width, height;
  std::vector<float> heights;
  float& at(uint32_t x, uint32_t y) { return heights[size_t{y} * width + x]; }
  VoidReport fill() { return fillVoids(heights, width, height); }
};

Grid plane(uint32_t width, uint32_t height) {
  Grid grid{width, height, std::vector<float>(size_t{width} * height)};
  for (uint32_t y = 0; y < height; ++y)
    for (uint32_t x = 0; x < width; ++x) grid.at(x, y) = 100.0f + static_cast<float>(x) + 2.0f * static_cast<float>(y);
  return grid;
}

void punch(Grid& grid, uint32_t x0, uint32_t y0, uint32_t x1, uint32_t y1) {
  for (uint32_t y = y0; y < y1; ++y)
    for (uint32_t x = x0; x < x1; ++x) grid.at(x, y) = kVoid;
}

TEST(Voids, DataIsNeverChangedAndNoVoidIsLeftWithinTheRangeOfTheData) {
  Rng rng(test::randomSeed());
  for (int round = 0; round < 30; ++round) {
    Grid grid = plane(static_cast<uint32_t>(1 + rng.below(70)), static_cast<uint32_t>(1 + rng.below(70)));
    grid.at(0, 0) = 100;
    const double share = rng.uniform();
    for (size_t i = 1; i < grid.heights.size(); ++i)
      if (rng.uniform() < share) grid.heights[i] = kVoid;
    const Grid before = grid;
    const VoidReport report = grid.fill();
    uint64_t voids = 0;
    float lowest = 1e9f, highest = -1e9f;
    for (const float h : before.heights)
      if (std::isfinite(h)) {
        lowest = std::min(lowest, h);
        highest = std::max(highest, h);
      }
    for (size_t i = 0; i < grid.heights.size(); ++i) {
      if (std::isfinite(before.heights[i])) {
        ASSERT_EQ(grid.heights[i], before.heights[i]);
        continue;
      }
      ++voids;
      ASSERT_GE(grid.heights[i], lowest - 0.01f);
      ASSERT_LE(grid.heights[i], highest + 0.01f);
    }
    EXPECT_EQ(report.samples, voids);
    EXPECT_EQ(report.note.empty(), voids == 0);
  }
}

TEST(Voids, AHoleInAPlaneBecomesThePlane) {
  Grid grid = plane(200, 150);
  const Grid truth = grid;
  punch(grid, 60, 50, 72, 61);
  const VoidReport report = grid.fill();
  EXPECT_EQ(report.samples, 12u * 11u);
  EXPECT_EQ(report.regions, 1u);
  EXPECT_EQ(report.flat_regions, 0u);
  for (size_t i = 0; i < grid.heights.size(); ++i) EXPECT_NEAR(grid.heights[i], truth.heights[i], 1.5);
}

TEST(Voids, TheFillMeetsItsRimWithoutAStep) {
  Grid grid = plane(200, 150);
  punch(grid, 60, 50, 90, 80);
  grid.fill();
  for (uint32_t y = 50; y < 80; ++y) EXPECT_LT(std::fabs(grid.at(60, y) - grid.at(59, y)), 6.0f);
}

TEST(Voids, AMissingHalfBecomesFlatAndLow) {
  Grid grid = plane(600, 600);
  punch(grid, 300, 0, 600, 600);
  const VoidReport report = grid.fill();
  EXPECT_EQ(report.flat_regions, 1u);
  EXPECT_EQ(report.largest_region, 300u * 600u);
  for (uint32_t y = 0; y < 600; y += 50) EXPECT_NEAR(grid.at(500, y), grid.at(500, 300), 5.0);
  EXPECT_LT(grid.at(500, 300), 399.0f + 2.0f * 120);  // low among the heights 399..1597 of the rim
}

TEST(Voids, RegionsAreCountedByTheirSides) {
  Grid grid = plane(40, 40);
  punch(grid, 2, 2, 5, 5);
  punch(grid, 5, 5, 8, 8);  // touches the first only at a corner
  punch(grid, 20, 20, 30, 21);
  punch(grid, 20, 21, 21, 30);
  punch(grid, 29, 21, 30, 30);  // a U
  EXPECT_EQ(grid.fill().regions, 3u);
}

TEST(Voids, NothingButVoidsIsSaidAndLeftAlone) {
  Grid grid{5, 4, std::vector<float>(20, kVoid)};
  EXPECT_TRUE(grid.fill().all_void);
  EXPECT_TRUE(std::isnan(grid.heights[7]));
}

TEST(Voids, InfinitiesAreVoids) {
  Grid grid = plane(9, 9);
  grid.at(4, 4) = std::numeric_limits<float>::infinity();
  EXPECT_EQ(grid.fill().samples, 1u);
  EXPECT_NEAR(grid.at(4, 4), 112.0f, 1.0f);
}

TEST(Voids, TheSameInputGivesTheSameFill) {
  Grid a = plane(300, 301);
  punch(a, 10, 10, 250, 250);
  Grid b = a;
  a.fill();
  b.fill();
  EXPECT_EQ(a.heights, b.heights);
}

}  // namespace
}  // namespace foreland::terrain
