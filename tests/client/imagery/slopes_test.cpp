// Slopes of tiles of relief, against planes and against each other.
#include "client/imagery/slopes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/packing.hpp>
#include <random>
#include <vector>

#include "tests/support/seed.h"

namespace foreland::test {
namespace {

using proto::kTileSide;

proto::TileLayer layerOf(uint32_t side, double texel, double step_m) {
  proto::TileLayer layer;
  layer.width = layer.height = side;
  layer.texel = texel;
  layer.step_m = step_m;
  return layer;
}

// Heights of a tile, by a function of its texels' columns and rows in the raster; beyond it they repeat.
template <class Height>
std::vector<int32_t> heightsOf(const proto::TileLayer& layer, const proto::TileId& tile, const Height& height) {
  std::vector<int32_t> out;
  for (int64_t y = 0; y < kTileSide; ++y)
    for (int64_t x = 0; x < kTileSide; ++x) {
      const auto at = [&](int64_t i, uint32_t t, uint32_t end) {
        return std::clamp<int64_t>(i + int64_t{t} * proto::kTilePayload - proto::kTileGutter, 0, int64_t{end} - 1);
      };
      out.push_back(height(at(x, tile.x, layer.widthAt(tile.level)), at(y, tile.y, layer.heightAt(tile.level))));
    }
  return out;
}

std::vector<uint32_t> slopesOf(const proto::TileLayer& layer, const proto::TileId& tile,
                               std::span<const int32_t> steps) {
  std::vector<uint32_t> out(proto::kTileTexels);
  client::slopesOf(layer, tile, steps, out);
  return out;
}

TEST(Slopes, OfAPlaneAreTheSameEverywhereUpToTheBordersOfTheRaster) {
  const proto::TileLayer layer = layerOf(700, 0.5, 0.25);
  for (const uint8_t level : {0, 1})
    for (const uint32_t x : {0u, 1u, 2u})
      for (const uint32_t y : {0u, 2u}) {
        const proto::TileId tile{0, level, x, y};
        if (!layer.has(tile)) continue;
        const auto plane = [](int64_t column, int64_t row) { return static_cast<int32_t>(3 * column - 2 * row); };
        for (const uint32_t slope : slopesOf(layer, tile, heightsOf(layer, tile, plane))) {
          // Steps and texels double from level to level.
          EXPECT_FLOAT_EQ(glm::unpackHalf2x16(slope).x, 3 * 0.25f / 0.5f);
          EXPECT_FLOAT_EQ(glm::unpackHalf2x16(slope).y, -2 * 0.25f / 0.5f);
        }
      }
}

// The half-size image of a tile of a wave is its parent's slopes, where the parent has them.
TEST(Slopes, AHalfSizeImageIsTheParentsWhereItLies) {
  std::mt19937 random(static_cast<uint32_t>(randomSeed()));
  std::vector<uint32_t> parent(proto::kTileTexels);
  for (uint32_t& p : parent) p = random();
  std::vector<uint32_t> half(size_t{client::kHalfSide} * client::kHalfSide);
  for (const uint32_t x : {4u, 5u})
    for (const uint32_t y : {6u, 7u}) {
      const proto::TileId tile{0, 3, x, y}, above = tile.parent();
      client::halfImageOf(tile, parent, half);
      for (uint32_t i = 0; i < 200; ++i) {
        // A texel of the half-size image, and its raster position in level 4; the same in the parent.
        const uint32_t column = random() % client::kHalfSide, row = random() % client::kHalfSide;
        const uint32_t at_x = x * proto::kTilePayload / 2 - proto::kTileGutter / 2 + column;
        const uint32_t at_y = y * proto::kTilePayload / 2 - proto::kTileGutter / 2 + row;
        const uint32_t in_x = at_x - (above.x * proto::kTilePayload - proto::kTileGutter);
        const uint32_t in_y = at_y - (above.y * proto::kTilePayload - proto::kTileGutter);
        EXPECT_EQ(half[row * client::kHalfSide + column], parent[in_y * kTileSide + in_x]);
      }
    }
}

// Normals from coarse steps against those of the surface itself, on a wavy ground of 30 m spacing: what the page is
// promised is 0.75 degrees in the mean square.
TEST(Slopes, NormalsFromCodedHeightsAreTheGrounds) {
  const double spacing_m = 30, step_m = spacing_m / 20;
  const proto::TileLayer layer = layerOf(248, 1, step_m);
  const auto height = [&](double x, double y) { return 300 * std::sin(x / 9) * std::cos(y / 13); };
  const auto steps = heightsOf(layer, {}, [&](int64_t x, int64_t y) {
    return static_cast<int32_t>(std::lround(height(static_cast<double>(x), static_cast<double>(y)) / step_m));
  });
  const auto slopes = slopesOf(layer, {}, steps);
  double sum = 0, count = 0;
  for (int y = 1; y < 247; ++y)
    for (int x = 1; x < 247; ++x) {
      const glm::vec2 slope = glm::unpackHalf2x16(slopes[static_cast<size_t>((y + 4) * int{kTileSide} + x + 4)]) /
                              static_cast<float>(spacing_m);
      const glm::dvec2 central{(height(x + 1, y) - height(x - 1, y)) / (2 * spacing_m),
                               (height(x, y + 1) - height(x, y - 1)) / (2 * spacing_m)};
      const glm::dvec3 one = glm::normalize(glm::dvec3(-slope.x, -slope.y, 1)),
                       other = glm::normalize(glm::dvec3(-central, 1));
      const double degrees = std::acos(std::min(1.0, glm::dot(one, other))) * 57.29577951;
      sum += degrees * degrees, ++count;
      EXPECT_LT(degrees, 2.3);
    }
  EXPECT_LT(std::sqrt(sum / count), 0.75);
}

}  // namespace
}  // namespace foreland::test
