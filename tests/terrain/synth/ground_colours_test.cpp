#include "terrain/synth/ground_colours.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

namespace foreland::terrain {
namespace {

using Colour = GroundColours::Colour;

// A plain in the west, a slope of 70 degrees, and a high plain in the east.
std::vector<float> cliff() {
  std::vector<float> metres;
  for (int y = 0; y < 40; ++y)
    for (int x = 0; x < 80; ++x) metres.push_back(static_cast<float>(std::clamp(27.5 * (x - 30), 0.0, 550.0)));
  return metres;
}

Colour meanOf(const GroundColours& ground, double x, double y) {
  std::array<double, 3> sum{};
  std::vector<Colour> row(64);
  for (int i = 0; i < 64; ++i) {
    ground.row(x, y + i / 8.0, 0.125, row);
    for (const Colour& c : row)
      for (size_t k = 0; k < 3; ++k) sum[k] += c[k] / 4096.0;
  }
  return {static_cast<uint8_t>(sum[0]), static_cast<uint8_t>(sum[1]), static_cast<uint8_t>(sum[2])};
}

TEST(GroundColours, AreGreenInTheValleyGreyOnCliffsAndWhiteOnTop) {
  const auto metres = cliff();
  const GroundColours ground({metres, 80, 40, {10, 10}}, 3);
  const Colour valley = meanOf(ground, 5, 10), rock = meanOf(ground, 35, 10), top = meanOf(ground, 65, 10);
  EXPECT_GT(valley[1], valley[0] + 8);
  EXPECT_GT(valley[1], valley[2] + 8);
  EXPECT_LT(rock[0] - rock[2], 40);
  EXPECT_LT(rock[1] - rock[2], (valley[1] - valley[2]) / 2) << "grey";
  EXPECT_GT(top[2], 200);
}

// Trees are told apart where texels are smaller than they.
TEST(GroundColours, HaveTreesWhereTexelsAreSmallEnough) {
  const std::vector<float> plain(size_t{400} * 400, 100);
  std::vector<float> metres = plain;
  metres[0] = 2000;  // elsewhere is low
  const GroundColours ground({metres, 400, 400, {10, 10}}, 3);
  // From texel to texel, mean over a square of 1.8 km of plain.
  const auto contrast = [&](double step) {
    std::vector<Colour> row(static_cast<size_t>(180 / step));
    double sum = 0;
    for (int y = 100; y < 280; ++y) {
      ground.row(100, y, step, row);
      for (size_t i = 1; i < row.size(); ++i) sum += std::abs(row[i][1] - row[i - 1][1]);
    }
    return sum / (180.0 * static_cast<double>(row.size() - 1));
  };
  EXPECT_GT(contrast(0.1), 3) << "texels of 1 m";
  EXPECT_LT(contrast(0.01), contrast(0.1)) << "each tree has many texels";
}

TEST(GroundColours, AreTheSameForTheSameSeedAndAnyWindow) {
  const auto metres = cliff();
  const GroundColours ground({metres, 80, 40, {10, 10}}, 3), other({metres, 80, 40, {10, 10}}, 4);
  std::vector<Colour> whole(160), part(40), another(160);
  ground.row(0, 7, 0.25, whole);
  ground.row(20, 7, 0.25, part);
  other.row(0, 7, 0.25, another);
  EXPECT_TRUE(std::equal(part.begin(), part.end(), whole.begin() + 80));
  EXPECT_NE(whole, another);
}

TEST(GroundColours, GoOnBeyondTheBorder) {
  const auto metres = cliff();
  std::vector<Colour> row(400);
  GroundColours({metres, 80, 40, {10, 10}}, 3).row(-10, -5, 0.25, row);
  const std::vector<float> level(4, 5);
  GroundColours({level, 2, 2, {1e-3, 1e-3}}, 3).row(0, 0, 0.01, row);
}

}  // namespace
}  // namespace foreland::terrain
