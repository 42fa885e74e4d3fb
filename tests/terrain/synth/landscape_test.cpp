#include "terrain/synth/landscape.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

namespace foreland::terrain {
namespace {

std::vector<float> allHeights(const Landscape& land) {
  std::vector<float> heights(size_t{land.info().width} * land.info().height);
  land.heights(0, land.info().height, heights);
  return heights;
}

constexpr int kSide = 513;

// 20 km a side, made once.
const std::vector<float>& mountains() {
  static const std::vector<float> heights =
      allHeights(**Landscape::create({.size = kSide, .spacing_m = 40, .seed = 1}));
  return heights;
}

TEST(Landscape, TheSameSeedGivesTheSameBytes) {
  const auto a = Landscape::create({.size = 129, .spacing_m = 20, .seed = 7}),
             b = Landscape::create({.size = 129, .spacing_m = 20, .seed = 7});
  EXPECT_EQ(allHeights(**a), allHeights(**b));
  const auto c = Landscape::create({.size = 129, .spacing_m = 20, .seed = 8});
  EXPECT_NE(allHeights(**a), allHeights(**c));
}

TEST(Landscape, AnyWindowGivesTheSameRows) {
  const auto land = Landscape::create({.size = 200, .spacing_m = 15, .seed = 3});
  const std::vector<float> whole = allHeights(**land);
  std::vector<float> part(3 * 200);
  (*land)->heights(77, 3, part);
  EXPECT_TRUE(std::equal(part.begin(), part.end(), whole.begin() + 77 * 200));
}

TEST(Landscape, EverySizeIsMadeAndFinite) {
  for (const uint32_t size : {2u, 3u, 5u, 17u, 64u, 333u}) {
    const auto land = Landscape::create({.size = size, .spacing_m = 10, .seed = 1});
    ASSERT_TRUE(land.ok());
    EXPECT_EQ((*land)->info().width, size);
    for (const float h : allHeights(**land)) ASSERT_TRUE(std::isfinite(h) && h > -500 && h < 5000) << h;
  }
}

TEST(Landscape, SizesAndSpacingsThatCannotBeMeantAreRefused) {
  EXPECT_FALSE(Landscape::create({.size = 1}).ok());
  EXPECT_FALSE(Landscape::create({.size = 5, .spacing_m = 0}).ok());
  EXPECT_FALSE(Landscape::create({.size = 5, .spacing_m = NAN}).ok());
}

TEST(Landscape, HeightsAreThoseOfMountains) {
  const std::vector<float>& heights = mountains();
  const auto [low, high] = std::minmax_element(heights.begin(), heights.end());
  EXPECT_NEAR(*low, 200, 50);
  EXPECT_NEAR(*high, 3000, 100);
}

// Eroded ground drains: few samples lie below all their neighbours, where plain noise has one in a hundred.
TEST(Landscape, HollowsAreRare) {
  const std::vector<float>& heights = mountains();
  int hollows = 0;
  for (int y = 1; y < kSide - 1; ++y)
    for (int x = 1; x < kSide - 1; ++x) {
      const float* h = heights.data() + y * kSide + x;
      bool is_lowest = true;
      for (const int d : {-kSide - 1, -kSide, -kSide + 1, -1, 1, kSide - 1, kSide, kSide + 1})
        is_lowest = is_lowest && h[d] > *h;
      hollows += is_lowest ? 1 : 0;
    }
  EXPECT_LT(hollows, kSide * kSide / 400);
}

}  // namespace
}  // namespace foreland::terrain
