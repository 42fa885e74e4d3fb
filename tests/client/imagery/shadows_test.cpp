// Shadows of tiles against rays over the heights of the whole raster, for any sun.
#include "client/imagery/shadows.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <map>
#include <random>
#include <vector>

#include "proto/imagery/relief_codec.h"
#include "tests/support/seed.h"

namespace foreland::test {
namespace {

using client::HeightCode;
using proto::kTileGutter, proto::kTilePayload, proto::kTileSide;

constexpr double kSpacing_m = 10, kStep_m = 0.25, kHighest_m = 1500;

// A raster of heights with its coarser levels, and the ground texels of all its tiles.
struct Raster {
  proto::TileLayer layer;
  HeightCode code;
  std::vector<std::vector<double>> levels;
  std::map<uint64_t, std::vector<uint32_t>> tiles;

  double at(uint32_t level, int64_t x, int64_t y) const {
    const auto in = [](int64_t i, uint32_t end) {
      return static_cast<size_t>(std::clamp<int64_t>(i, 0, int64_t{end} - 1));
    };
    return levels[level][in(y, layer.heightAt(level)) * layer.widthAt(level) + in(x, layer.widthAt(level))];
  }
  double between(double x, double y) const {
    const auto i = static_cast<int64_t>(std::floor(x)), j = static_cast<int64_t>(std::floor(y));
    const double u = x - static_cast<double>(i), v = y - static_cast<double>(j);
    return (at(0, i, j) * (1 - u) + at(0, i + 1, j) * u) * (1 - v) +
           (at(0, i, j + 1) * (1 - u) + at(0, i + 1, j + 1) * u) * v;
  }
};

Raster makeRaster(uint32_t side, std::mt19937& random) {
  std::uniform_real_distribution<double> unit(0, 1);
  Raster r;
  r.layer.width = r.layer.height = side;
  r.layer.origin = {-0.5, -0.5};
  r.layer.step_m = kStep_m;
  r.code = HeightCode::of(r.layer, 0, kHighest_m);
  const double wave = 0.05 + 0.1 * unit(random), turn = 6 * unit(random);
  r.levels.emplace_back();
  for (uint32_t y = 0; y < side; ++y)
    for (uint32_t x = 0; x < side; ++x) {
      const double hills =
          std::sin(wave * x + turn) * std::cos(0.7 * wave * y) + 0.4 * std::sin(0.31 * x + 0.23 * y + turn);
      r.levels[0].push_back(std::clamp(600 + 200 * hills, 0.0, kHighest_m));
    }
  for (uint32_t level = 1; level < r.layer.levels(); ++level) {
    std::vector<double> coarse;
    for (int64_t y = 0; y < int64_t{r.layer.heightAt(level)}; ++y)
      for (int64_t x = 0; x < int64_t{r.layer.widthAt(level)}; ++x)
        coarse.push_back((r.at(level - 1, 2 * x, 2 * y) + r.at(level - 1, 2 * x + 1, 2 * y) +
                          r.at(level - 1, 2 * x, 2 * y + 1) + r.at(level - 1, 2 * x + 1, 2 * y + 1)) /
                         4);
    r.levels.push_back(std::move(coarse));
  }
  return r;
}

proto::FrameTransform planar() {
  proto::Frame frame;
  frame.axis_x_m = {kSpacing_m, 0};
  frame.axis_y_m = {0, kSpacing_m};
  return proto::FrameTransform(frame);
}

const std::vector<uint32_t>& tileOf(Raster& r, const proto::TileId& tile, const glm::dvec3& sun) {
  auto& out = r.tiles[tile.key()];
  if (!out.empty()) return out;
  const double step_m = kStep_m * static_cast<double>(1u << tile.level);
  std::vector<int32_t> steps;
  for (int64_t y = 0; y < kTileSide; ++y)
    for (int64_t x = 0; x < kTileSide; ++x)
      steps.push_back(
          static_cast<int32_t>(std::lround(r.at(tile.level, int64_t{tile.x} * kTilePayload + x - kTileGutter,
                                                int64_t{tile.y} * kTilePayload + y - kTileGutter) /
                                           step_m)));
  std::vector<uint32_t> texels(proto::kTileTexels);
  client::groundOf(r.layer, tile, r.code, steps, texels);
  std::vector<uint32_t> parent;
  if (!r.layer.isCoarsest(tile)) parent = tileOf(r, tile.parent(), sun);
  client::castShadows(r.layer, tile, planar(), r.code, sun, parent, texels);
  return out = std::move(texels);
}

glm::dvec3 sunAt(double azimuth, double height) {
  return {std::sin(azimuth) * std::cos(height), std::cos(azimuth) * std::cos(height), std::sin(height)};
}

// The height below which a sample lies in shadow: along the ray towards the sun, to the raster's end.
double shadowAt(const Raster& r, double x, double y, const glm::dvec3& sun) {
  const glm::dvec2 ahead = glm::normalize(glm::dvec2(sun));
  const double fall = sun.z / glm::length(glm::dvec2(sun)) * kSpacing_m, end = r.layer.width - 1.0;
  double most = -1e9;
  for (double t = 0.25; t < 3 * end; t += 0.25) {
    const glm::dvec2 p = glm::dvec2(x, y) + t * ahead;
    if (p.x < 0 || p.y < 0 || p.x > end || p.y > end) break;
    most = std::max(most, r.between(p.x, p.y) - t * fall);
    if (kHighest_m - t * fall < most) break;
  }
  return most;
}

struct Agreement {
  uint32_t texels = 0, dark = 0, wrong = 0, clearly_wrong = 0;
};

// Texels more than `margin_m` above or below the edge of a shadow are clear.
Agreement compare(Raster& r, const proto::TileId& tile, const glm::dvec3& sun, double margin_m) {
  Agreement a;
  const auto& texels = tileOf(r, tile, sun);
  for (uint32_t y = 6; y < kTilePayload; y += 5)
    for (uint32_t x = 6; x < kTilePayload; x += 5) {
      const double column = double(tile.x) * kTilePayload + x, row = double(tile.y) * kTilePayload + y;
      if (column >= r.layer.width || row >= r.layer.height) continue;
      const uint32_t texel = texels[(y + kTileGutter) * kTileSide + x + kTileGutter];
      const double over_m =
          shadowAt(r, column, row, sun) - r.at(0, static_cast<int64_t>(column), static_cast<int64_t>(row));
      const bool is_dark = (texel >> 16) > (texel & 0xffff);
      ++a.texels, a.dark += over_m > 0 ? 1 : 0;
      a.wrong += is_dark != (over_m > 0) ? 1 : 0;
      a.clearly_wrong += is_dark != (over_m > 0) && std::abs(over_m) > margin_m ? 1 : 0;
    }
  return a;
}

TEST(Shadows, OfARasterOfOneTileAreThoseOfRays) {
  std::mt19937 random(static_cast<uint32_t>(randomSeed()));
  std::uniform_real_distribution<double> unit(0, 1);
  Agreement sum;
  for (int i = 0; i < 12; ++i) {
    Raster r = makeRaster(240, random);
    const Agreement a = compare(r, {}, sunAt(6.283 * unit(random), 0.08 + 0.5 * unit(random)), 3);
    sum.texels += a.texels, sum.dark += a.dark, sum.clearly_wrong += a.clearly_wrong;
  }
  EXPECT_GT(sum.dark, sum.texels / 20);
  EXPECT_LE(sum.clearly_wrong, sum.texels / 400) << "of " << sum.texels;
}

// Ground beyond a tile is known the coarser the further it is away, and still casts where it does in truth.
TEST(Shadows, ReachOverTheBordersOfTiles) {
  std::mt19937 random(static_cast<uint32_t>(randomSeed()));
  std::uniform_real_distribution<double> unit(0, 1);
  Agreement sum;
  for (int i = 0; i < 12; ++i) {
    Raster r = makeRaster(900, random);
    const glm::dvec3 sun = sunAt(6.283 * unit(random), 0.1 + 0.3 * unit(random));
    for (const uint32_t y : {1u, 2u})
      for (const uint32_t x : {0u, 1u, 2u}) {
        const Agreement a = compare(r, {0, 0, x, y}, sun, 30);
        sum.texels += a.texels, sum.dark += a.dark, sum.wrong += a.wrong, sum.clearly_wrong += a.clearly_wrong;
      }
  }
  EXPECT_GT(sum.dark, sum.texels / 20);
  EXPECT_LE(sum.wrong, sum.texels / 50);
  EXPECT_LE(sum.clearly_wrong, sum.texels / 1000);
}

TEST(Shadows, OnALevelPlaneAreNoneByDayAndEverywhereByNight) {
  Raster r;
  r.layer.width = r.layer.height = 700;
  r.layer.origin = {-0.5, -0.5};
  r.layer.step_m = kStep_m;
  r.code = HeightCode::of(r.layer, 0, kHighest_m);
  for (uint32_t level = 0; level < r.layer.levels(); ++level)
    r.levels.emplace_back(size_t{r.layer.widthAt(level)} * r.layer.heightAt(level), 400);
  for (const bool is_night : {false, true}) {
    r.tiles.clear();
    for (const uint32_t t : tileOf(r, {0, 0, 1, 1}, sunAt(1, is_night ? -0.2 : 0.03)))
      ASSERT_EQ((t >> 16) > (t & 0xffff), is_night);
  }
}

TEST(Shadows, AreTakenAwayAgain) {
  std::mt19937 random(static_cast<uint32_t>(randomSeed()));
  Raster r = makeRaster(240, random);
  std::vector<uint32_t> texels = tileOf(r, {}, sunAt(1, 0.1));
  client::clearShadows(texels);
  for (size_t i = 0; i < texels.size(); ++i) ASSERT_EQ(texels[i], tileOf(r, {}, sunAt(1, 0.1))[i] & 0xffff);
}

// What a code stands for is the height, to half a code.
TEST(Shadows, HeightsAreCodedToHalfACode) {
  std::mt19937 random(static_cast<uint32_t>(randomSeed()));
  Raster r = makeRaster(240, random);
  const auto& texels = tileOf(r, {}, sunAt(1, 0.5));
  EXPECT_LT(r.code.step_m, 0.05);
  for (uint32_t y = 0; y < 240; ++y)
    for (uint32_t x = 0; x < 240; ++x) {
      const double height_m =
          r.code.low_m + r.code.step_m * (texels[(y + kTileGutter) * kTileSide + x + kTileGutter] & 0xffff);
      ASSERT_NEAR(height_m, r.at(0, x, y), 0.5 * kStep_m + 0.51 * r.code.step_m);
    }
}

}  // namespace
}  // namespace foreland::test
