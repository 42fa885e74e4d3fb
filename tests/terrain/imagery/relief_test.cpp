// Relief tiles of a scene file: exactly the means of the scene's heights, whatever its size and frame.
#include "terrain/imagery/relief.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "proto/imagery/relief_codec.h"
#include "terrain/imagery/verify_tiles.h"
#include "tests/support/data.h"
#include "tests/support/scene.h"
#include "tests/support/seed.h"

namespace foreland::terrain {
namespace {

using proto::kTileGutter;
using proto::kTilePayload;
using proto::kTileSide;
using proto::TileId;

std::vector<int32_t> decoded(const Scene& scene, const TileId& tile) {
  std::vector<int32_t> steps(proto::kTileTexels);
  EXPECT_TRUE(proto::decodeRelief(scene.tiles().bytes(tile), steps).ok());
  return steps;
}

// A level of the pyramid in metres, made from the scene's heights alone. Beyond its border a raster repeats it.
struct Level {
  uint32_t width, height;
  std::vector<double> metres;
  double at(int64_t x, int64_t y) const {
    const auto cx = std::clamp<int64_t>(x, 0, width - 1), cy = std::clamp<int64_t>(y, 0, height - 1);
    return metres[static_cast<size_t>(cy * width + cx)];
  }
};

std::vector<Level> pyramidOf(const Scene& scene, uint32_t levels) {
  const proto::GridShape& s = scene.grid().shape();
  std::vector<Level> pyramid{{s.samples_x, s.samples_y, {}}};
  for (uint32_t y = 0; y < s.samples_y; ++y)
    for (uint32_t x = 0; x < s.samples_x; ++x)
      pyramid[0].metres.push_back(scene.height(proto::NodeId::at(x, y)) * scene.frame().height_quantum_m);
  while (pyramid.size() < levels) {
    const Level& fine = pyramid.back();
    Level coarse{(fine.width + 1) / 2, (fine.height + 1) / 2, {}};
    for (int64_t y = 0; y < coarse.height; ++y)
      for (int64_t x = 0; x < coarse.width; ++x)
        coarse.metres.push_back((fine.at(2 * x, 2 * y) + fine.at(2 * x + 1, 2 * y) + fine.at(2 * x, 2 * y + 1) +
                                 fine.at(2 * x + 1, 2 * y + 1)) /
                                4);
    pyramid.push_back(std::move(coarse));
  }
  return pyramid;
}

template <class Visit>
void forEachTexel(const TileId& tile, const Visit& visit) {
  size_t i = 0;
  for (uint32_t y = 0; y < kTileSide; ++y)
    for (uint32_t x = 0; x < kTileSide; ++x, ++i)
      visit(i, int64_t{tile.x} * kTilePayload + x - kTileGutter, int64_t{tile.y} * kTilePayload + y - kTileGutter);
}

void expectLaws(const Scene& scene) {
  const TileTable& tiles = scene.tiles();
  ASSERT_EQ(tiles.layers().size(), 1u);
  const proto::TileLayer& layer = tiles.layers()[0];
  EXPECT_EQ(layer.width, scene.grid().shape().samples_x);
  EXPECT_EQ(layer.height, scene.grid().shape().samples_y);
  const auto pyramid = pyramidOf(scene, layer.levels());
  tiles.forEach(0, [&](const TileId& tile) {
    const auto bounds = tiles.bounds(tile);
    ASSERT_TRUE(bounds.has_value());
    const auto steps = decoded(scene, tile);
    const double step_m = layer.step_m * std::exp2(tile.level);
    const Level& level = pyramid[tile.level];
    // Gutters too, so neighbours hold the same.
    forEachTexel(tile, [&](size_t i, int64_t x, int64_t y) {
      ASSERT_NEAR(steps[i] * step_m, level.at(x, y), 0.5001 * step_m) << tile.level << ' ' << x << ' ' << y;
    });
    const proto::LatticeBox box = layer.boxOf(tile);
    const Level& finest = pyramid[0];
    for (auto y = static_cast<int64_t>(std::ceil(box.low.y)); y <= box.high.y; ++y)
      for (auto x = static_cast<int64_t>(std::ceil(box.low.x)); x <= box.high.x; ++x) {
        ASSERT_LE(bounds->lowest_m, finest.at(x, y));
        ASSERT_GE(bounds->highest_m, finest.at(x, y));
      }
  });
  const TilesReport report = verifyTiles(scene, 2);
  EXPECT_EQ(report.faults, 0u) << report.first_faults.front();
  ASSERT_EQ(report.layers.size(), 1u);
  EXPECT_EQ(report.layers[0].tiles, tileCount(layer));
}

TEST(Relief, TilesAreTheMeansOfTheScenesHeights) {
  Rng rng(test::randomSeed());
  for (const auto kind : {proto::FrameKind::kPlanar, proto::FrameKind::kGeographic}) {
    expectLaws(*test::makeScene(2, 2, rng.next(), kind));
    expectLaws(*test::makeScene(248, 5, rng.next(), kind));
    expectLaws(*test::makeScene(static_cast<uint32_t>(249 + rng.below(400)), static_cast<uint32_t>(2 + rng.below(600)),
                                rng.next(), kind));
  }
}

// The half-size image of a tile is a quarter of its parent, but for what the steps of both round.
TEST(Relief, HalfATileIsAQuarterOfItsParent) {
  const auto scene = test::makeScene(700, 521, test::randomSeed());
  const proto::TileLayer& layer = scene->tiles().layers()[0];
  scene->tiles().forEach(0, [&](const TileId& tile) {
    if (tile.level + 1u == layer.levels()) return;
    const auto fine = decoded(*scene, tile), coarse = decoded(*scene, tile.parent());
    const double step_m = layer.step_m * std::exp2(tile.level);
    const auto first = [](uint32_t at) { return at % 2 ? kTileSide / 2 - kTileGutter / 2 : kTileGutter / 2; };
    forEachTexel(tile, [&](size_t i, int64_t x, int64_t y) {
      const auto tx = static_cast<uint32_t>(i % kTileSide), ty = static_cast<uint32_t>(i / kTileSide);
      const bool is_within =
          x >= 0 && y >= 0 && x + 1 < layer.widthAt(tile.level) && y + 1 < layer.heightAt(tile.level);
      if (tx % 2 || ty % 2 || !is_within) return;
      const double mean = (fine[i] + fine[i + 1] + fine[i + kTileSide] + fine[i + kTileSide + 1]) / 4.0;
      const int32_t own = coarse[(first(tile.y) + ty / 2) * kTileSide + first(tile.x) + tx / 2];
      ASSERT_NEAR(own * 2 * step_m, mean * step_m, 1.5001 * step_m);
    });
  });
}

TEST(Relief, StepsAreATwentiethOfTheSpacingInWholeQuanta) {
  proto::Frame frame = test::makeFrame(proto::FrameKind::kPlanar, 100, 100);  // 10 m
  const auto step = [&](double quantum_m) {
    frame.height_quantum_m = quantum_m;
    return reliefLayer(100, 100, frame).step_m;
  };
  EXPECT_DOUBLE_EQ(step(0.1), 0.5);
  EXPECT_DOUBLE_EQ(step(0.3), 0.3);
  EXPECT_DOUBLE_EQ(step(1), 1);
  frame.axis_x_m = {1e5, 0}, frame.axis_y_m = {0, 1e5};
  EXPECT_DOUBLE_EQ(step(1), 10);
  frame.axis_x_m = {21.4, 0}, frame.axis_y_m = {0, 30};
  EXPECT_DOUBLE_EQ(step(1), 1);
}

TEST(Relief, IsTheSameForAnyNumberOfThreads) {
  const test::TemporaryFolder folder;
  for (unsigned threads : {1u, 4u}) {
    test::FormulaSource source(700, 300, test::hills(5));
    ASSERT_TRUE(buildScene(source, {.output = folder / std::to_string(threads), .threads = threads}).ok());
  }
  EXPECT_EQ(test::slurp(folder / "1"), test::slurp(folder / "4"));
}

TEST(Relief, StopsWhenItIsTold) {
  const test::TemporaryFolder folder;
  test::FormulaSource source(700, 300, test::hills(5));
  bool in_relief = false;
  const auto report = buildScene(source, {.output = folder / "a.fls", .threads = 2},
                                 {.report = [&](std::string_view stage, double) { in_relief = stage == "relief"; },
                                  .keepGoing = [&] { return !in_relief; }});
  ASSERT_FALSE(report.ok());
  EXPECT_NE(report.error().message.find("stopped"), std::string::npos);
  EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
}

TEST(Relief, ScenesThatChangeHaveNone) { EXPECT_TRUE(test::makeMovingScene(40, 30, 1, 3)->tiles().layers().empty()); }

}  // namespace
}  // namespace foreland::terrain
