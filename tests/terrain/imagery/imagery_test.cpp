// A picture as tiles of a scene: the right colours at the right positions, and nothing that coarser tiles show as well.
#include "terrain/imagery/imagery.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <vector>

#include "terrain/imagery/verify_tiles.h"
#include "terrain/imagery/webp.h"
#include "tests/support/formula_picture.h"
#include "tests/support/scene.h"
#include "tests/support/seed.h"

namespace foreland::terrain {
namespace {

using proto::TileId;
using test::FormulaPicture;

std::shared_ptr<const Scene> sceneWith(PictureSource& picture, uint32_t width, uint32_t height, unsigned threads = 2,
                                       std::filesystem::path path = {}) {
  const test::TemporaryFolder folder;
  if (path.empty()) path = folder / "scene.fls";
  test::FormulaSource source(width, height, test::hills(4));
  const auto report =
      buildScene(source, {.output = path,
                          .threads = threads,
                          .additions = {.picture = &picture, .imagery_quality = 90, .attribution = "a formula"}});
  EXPECT_TRUE(report.ok()) << report.error().message;
  return *Scene::open(path);
}

uint8_t wave(double phase) { return static_cast<uint8_t>(std::lround(128 + 80 * std::sin(phase))); }

TEST(Imagery, EveryLevelHasTheColoursWhereTheyBelong) {
  const auto formula = [](double x, double y) {
    return Rgba{wave(x * 0.07), wave(y * 0.09 + 1), wave((x + y) * 0.05), 255};
  };
  for (const double texel : {0.25, 1.0, 2.0}) {
    FormulaPicture picture(151, 123, texel, [&](double x, double y) {
      // Detail, so that no tile is left out; it vanishes in means of 2 x 2.
      const Rgba c = formula(x, y);
      const bool odd = static_cast<int>(std::floor(x / texel) + std::floor(y / texel)) % 2 != 0;
      return Rgba{c.red, static_cast<uint8_t>(c.green + (odd ? 12 : -12)), c.blue, 255};
    });
    const auto scene = sceneWith(picture, 151, 123);
    ASSERT_EQ(scene->tiles().layers().size(), 2u);
    const proto::TileLayer& layer = scene->tiles().layers()[1];
    EXPECT_EQ(layer.attribution, "a formula");
    EXPECT_EQ(layer.texel, texel);
    EXPECT_EQ(verifyTiles(*scene).faults, 0u);
    std::vector<Rgb> pixels(size_t{proto::kTileSide} * proto::kTileSide);
    scene->tiles().forEach(1, [&](const TileId& tile) {
      ASSERT_TRUE(scene->tiles().bounds(tile));
      ASSERT_TRUE(decodeTile(scene->tiles().bytes(tile), pixels).ok());
      double squares = 0;
      uint64_t count = 0;
      const glm::dvec2 corner = layer.cornerOf(tile);
      const double size = layer.texelAt(tile.level);
      for (uint32_t y = 0; y < proto::kTileSide; ++y)
        for (uint32_t x = 0; x < proto::kTileSide; ++x) {
          const glm::dvec2 at = corner + glm::dvec2(x + 0.5 - proto::kTileGutter, y + 0.5 - proto::kTileGutter) * size;
          const bool is_within = at.x > 0 && at.y > 0 && at.x < 150 && at.y < 122;
          if (!is_within) continue;
          const Rgba wanted = formula(at.x, at.y);
          const Rgb& got = pixels[size_t{y} * proto::kTileSide + x];
          squares += std::pow(got[0] - wanted.red, 2) + std::pow(got[2] - wanted.blue, 2), count += 2;
        }
      EXPECT_LT(std::sqrt(squares / static_cast<double>(count)), 8) << texel << ' ' << int{tile.level};
    });
  }
}

TEST(Imagery, TilesThatShowNothingNewAreNotStoredNorAreFinerOnes) {
  // Flat, but for a corner.
  FormulaPicture picture(400, 300, 0.5, [](double x, double y) {
    const bool odd = static_cast<int>(std::floor(2 * x) + std::floor(2 * y)) % 2 != 0;
    return x < 100 && y < 60 && odd ? Rgba{255, 255, 255, 255} : Rgba{90, 120, 60, 255};
  });
  const auto scene = sceneWith(picture, 400, 300);
  const TileTable& tiles = scene->tiles();
  const proto::TileLayer& layer = tiles.layers()[1];
  uint64_t stored = 0;
  tiles.forEach(1, [&](const TileId& tile) {
    if (!tiles.bounds(tile)) return;
    ++stored;
    EXPECT_TRUE(tile.level + 1u == layer.levels() || tiles.bounds(tile.parent())) << "a tile without its parent";
    EXPECT_TRUE(tile.level > 0 || tiles.detail(tile) >= kMinDetail);
  });
  EXPECT_TRUE(tiles.bounds(TileId{1, 0, 0, 0}));
  EXPECT_FALSE(tiles.bounds(TileId{1, 0, 3, 2}));
  EXPECT_EQ(stored, layer.levels());
  EXPECT_EQ(verifyTiles(*scene).faults, 0u);
}

TEST(Imagery, IsTheSameForAnyNumberOfThreads) {
  const test::TemporaryFolder folder;
  for (unsigned threads : {1u, 4u}) {
    FormulaPicture picture(300, 200, 0.25, [](double x, double y) {
      return Rgba{wave(x * 1.7), wave(y * 2.3), wave(x * y), static_cast<uint8_t>(x < 40 ? 0 : 255)};
    });
    sceneWith(picture, 300, 200, threads, folder / std::to_string(threads));
  }
  EXPECT_EQ(test::slurp(folder / "1"), test::slurp(folder / "4"));
}

TEST(Imagery, WhatIsNotCoveredIsNoted) {
  FormulaPicture picture(60, 50, 1, [](double x, double) {
    return Rgba{200, 10, 10, static_cast<uint8_t>(x < 29.6 ? 255 : 0)};
  });
  const auto scene = sceneWith(picture, 60, 50);
  const auto& notes = scene->origin().notes;
  ASSERT_FALSE(notes.empty());
  EXPECT_NE(notes.back().find("cover 50 %"), std::string::npos) << notes.back();
}

TEST(Imagery, ScenesThatChangeHaveItWithBoundsOfAllTimes) {
  test::FormulaSource whole(40, 30, test::hills(1));
  test::FormulaSource first = test::windowSource(whole, {0, 0, 40, 30}, test::hills(1)),
                      second = test::windowSource(whole, {5, 5, 20, 20}, [](uint32_t, uint32_t) { return 3000.0; });
  FormulaPicture picture(40, 30, 0.5, [](double x, double y) { return Rgba{wave(x), wave(y), 0, 255}; });
  const test::TemporaryFolder folder;
  const auto report = buildScene(whole, {.output = folder / "a.fls",
                                         .threads = 1,
                                         .epochs = {{Time{0}, "a", &first}, {Time{1000}, "b", &second}},
                                         .additions = {.picture = &picture}});
  ASSERT_TRUE(report.ok()) << report.error().message;
  const auto scene = *Scene::open(folder / "a.fls");
  ASSERT_EQ(scene->tiles().layers().size(), 1u);
  EXPECT_GE(scene->tiles().bounds(TileId{0, 0, 0, 0})->highest_m, 3000);
  EXPECT_EQ(verifyTiles(*scene).faults, 0u);
}

TEST(Imagery, StopsAndFailsWithoutAFile) {
  const test::TemporaryFolder folder;
  const auto build = [&](PictureSource& picture, const Progress& progress) {
    test::FormulaSource source(600, 500, test::hills(4));
    return buildScene(source, {.output = folder / "a.fls", .additions = {.picture = &picture}}, progress);
  };
  FormulaPicture picture(600, 500, 0.5, [](double x, double y) { return Rgba{wave(x), wave(y), 0, 255}; });
  bool in_imagery = false;
  const auto stopped =
      build(picture, {.report = [&](std::string_view stage, double) { in_imagery = stage == "imagery"; },
                      .keepGoing = [&] { return !in_imagery; }});
  ASSERT_FALSE(stopped.ok());
  class Broken final : public PictureSource {
   public:
    const PictureInfo& info() const override { return info_; }
    Status read(const PictureWindow&, std::span<Rgba>) override {
      return Error{ErrorCode::kMalformed, "picture.tif: cut short"};
    }
    PictureInfo info_{.width = 600, .height = 500, .origin = {-0.5, -0.5}, .notes = {}};
  } broken;
  const auto failed = build(broken, {});
  ASSERT_FALSE(failed.ok());
  EXPECT_EQ(failed.error().message, "picture.tif: cut short");
  EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
}

}  // namespace
}  // namespace foreland::terrain
