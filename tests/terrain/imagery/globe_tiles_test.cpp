// Tiles of globes: a texel is what a picture shows at its latitude and longitude, on all faces, at edges, corners and
// poles; gutters are the neighbours' texels; relief is the ground; and verify finds what is wrong.
#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>

#include "proto/imagery/relief_codec.h"
#include "proto/space/cube_map.h"
#include "terrain/imagery/cube_fold.h"
#include "terrain/imagery/globe_imagery.h"
#include "terrain/imagery/globe_relief.h"
#include "terrain/imagery/tile_picture.h"
#include "terrain/imagery/verify_tiles.h"
#include "terrain/store/scene.h"
#include "tests/support/files.h"
#include "tests/support/globe_scene.h"
#include "tests/support/seed.h"

namespace foreland::terrain {
namespace {

using proto::kTileGutter;
using proto::kTilePayload;
using proto::kTileSide;
using proto::TileId;

glm::dvec3 directionOf(const FacePlace& p, double side) {
  return glm::normalize(proto::cubeVector({p.face, 2 * p.x / side - 1, 2 * p.y / side - 1}));
}

// Smooth over the body, and different everywhere.
Rgba colourOf(const glm::dvec3& direction) {
  const glm::dvec3 d = glm::normalize(direction);
  const auto part = [](double v) { return static_cast<uint8_t>(std::lround(127 + 100 * v)); };
  return {part(d.x), part(d.y), part(d.z), 255};
}

// One picture of the whole body, and a finer one about a direction.
class Painted final : public GlobePicture {
 public:
  Painted(double spacing_rad, double finer_rad, const glm::dvec3& about)
      : spacing_rad_(spacing_rad), finer_rad_(finer_rad), about_(glm::normalize(about)) {}
  const std::vector<std::string>& notes() const override { return notes_; }
  double finestSpacing() const override { return finer_rad_; }
  double spacingIn(const GlobePatch& patch) const override {
    const bool is_there = std::acos(std::clamp(glm::dot(patch.middle, about_), -1.0, 1.0)) < patch.angle_rad + 0.05;
    return is_there ? finer_rad_ : spacing_rad_;
  }
  // Where it is finer there is something to see.
  Rgba colourAt(const glm::dvec3& direction, double) const override {
    Rgba colour = colourOf(direction);
    const glm::dvec3 d = glm::normalize(direction);
    if (finer_rad_ < spacing_rad_ && glm::distance(d, about_) < 0.05)
      colour.green = static_cast<uint8_t>(127 + 100 * std::sin(d.z / finer_rad_));
    return colour;
  }

 private:
  double spacing_rad_, finer_rad_;
  glm::dvec3 about_;
  std::vector<std::string> notes_;
};

TEST(CubeFold, PlacesBeyondASideAreNextToIt) {
  Rng rng(test::randomSeed());
  constexpr double kSide = 64;
  for (uint32_t face = 0; face < 6; ++face)
    for (int i = 0; i < 100; ++i) {
      const double along = rng.uniform(1, kSide - 1), off = 1e-6;
      for (const glm::dvec2 p : {glm::dvec2(-off, along), glm::dvec2(kSide + off, along), glm::dvec2(along, -off),
                                 glm::dvec2(along, kSide + off)}) {
        const FacePlace there = foldedOver(FacePlace{face, p.x, p.y}, kSide);
        ASSERT_NE(there.face, face);
        const glm::dvec2 edge = glm::clamp(p, 0.0, kSide);
        ASSERT_LT(glm::distance(directionOf(there, kSide), directionOf({face, edge.x, edge.y}, kSide)), 1e-6)
            << "face " << face;
      }
    }
}

TEST(CubeFold, NeighboursOfNeighboursAreWhereTheyWere) {
  constexpr int64_t kSide = 16;
  for (uint32_t face = 0; face < 6; ++face)
    for (int64_t i = 0; i < kSide; ++i)
      for (const FaceTexel t : {FaceTexel{face, -1, i}, {face, kSide, i}, {face, i, -1}, {face, i, kSide}}) {
        const FaceTexel there = foldedOver(t, kSide);
        ASSERT_EQ(there.beyond(kSide), 0);
        // The texel next to it within the face is one beyond a side of the other one.
        const FaceTexel own{face, std::clamp<int64_t>(t.x, 0, kSide - 1), std::clamp<int64_t>(t.y, 0, kSide - 1)};
        int found = 0;
        for (const auto& [dx, dy] : {std::pair(-1, 0), {1, 0}, {0, -1}, {0, 1}}) {
          const FaceTexel back{there.face, there.x + dx, there.y + dy};
          found += back.beyond(kSide) == 1 && foldedOver(back, kSide) == own ? 1 : 0;
        }
        ASSERT_EQ(found, 1);
      }
}

class GlobeTiles : public testing::Test {
 protected:
  // A globe with imagery, through the real file; its own kind of relief with it.
  std::shared_ptr<const Scene> make(const GlobePicture& picture, uint32_t face_log2, uint32_t sparse_levels) {
    const std::shared_ptr<const Scene> bare = test::makeGlobeScene(face_log2, seed, sparse_levels);
    const proto::GridTopology& grid = bare->grid();
    std::vector<proto::Slot> pages;
    bare->pages().forEachPage([&](proto::Slot first, uint64_t) { pages.push_back(first); });
    const std::filesystem::path file = folder / "with_tiles.fls";
    std::optional<TileSection> tiles;
    SceneOrigin origin;
    origin.title = "globe";
    const auto report = buildSparseScene(
        {grid, bare->frame(), pages, [&](proto::NodeId n) { return bare->height(n); }},
        {file, 2, origin, {}, PageCoding::kPlain, [&](const StoredHeights& ground, SceneWriter::About& about) {
           tiles.emplace(std::move(TileSection::create(file).value()));
           const proto::Frame& frame = bare->frame();
           const SparseGroundBounds bounds(ground, frame);
           const auto on = [](double) { return true; };
           EXPECT_TRUE(*addGlobeRelief(ground, bounds, frame, file, 2, on, *tiles));
           const BoundsOf boundsOf = [&](const proto::LatticeBox& box, std::vector<glm::dvec3>&) {
             return bounds.over(box);
           };
           EXPECT_TRUE(addGlobeImagery(picture, frame.face_steps, boundsOf, {95, "painted", file, 2}, on, *tiles).ok());
           about.tiles = &*tiles;
           return Status();
         }});
    EXPECT_TRUE(report.ok()) << report.error().message;
    auto scene = Scene::open(file);
    EXPECT_TRUE(scene.ok()) << scene.error().message;
    return *scene;
  }
  test::TemporaryFolder folder;
  uint64_t seed = test::randomSeed();
};

// A texel of a tile as the lattice place in its middle.
FaceTexel texelOf(const proto::TileLayer& layer, const TileId& tile, uint32_t i, uint32_t j) {
  return {layer.faceOf(tile), int64_t{layer.columnOf(tile)} * kTilePayload + i - kTileGutter,
          int64_t{tile.y} * kTilePayload + j - kTileGutter};
}

TEST_F(GlobeTiles, ShowThePictureOnAllFacesEdgesCornersAndPoles) {
  const Painted picture(0.004, 0.004, {1, 0, 0});
  const auto scene = make(picture, 7, 0);
  const TileTable& tiles = scene->tiles();
  ASSERT_EQ(tiles.layers().size(), 2u);
  const proto::TileLayer& layer = tiles.layers()[1];
  ASSERT_GE(layer.levels(), 2u);
  std::array<int, 6> on_face{};
  int gutters = 0, corners = 0;
  std::vector<Rgb> pixels(size_t{kTileSide} * kTileSide);
  tiles.forEach(1, [&](const TileId& tile) {
    if (!tiles.bounds(tile)) return;
    ASSERT_TRUE(decodeTile(tiles.bytes(tile), pixels).ok());
    const int64_t side = layer.widthAt(tile.level);
    for (uint32_t j = 0; j < kTileSide; j += 3)
      for (uint32_t i = 0; i < kTileSide; i += 3) {
        const FaceTexel t = texelOf(layer, tile, i, j);
        if (t.x >= side + kTileGutter || t.y >= side + kTileGutter) continue;
        const bool is_corner = t.beyond(side) == 2;
        const FaceTexel there =
            is_corner ? FaceTexel{t.face, std::clamp<int64_t>(t.x, 0, side - 1), std::clamp<int64_t>(t.y, 0, side - 1)}
                      : foldedOver(t, side);
        const Rgba wanted =
            colourOf(directionOf({there.face, static_cast<double>(there.x) + 0.5, static_cast<double>(there.y) + 0.5},
                                 static_cast<double>(side)));
        // WebP is lossy, and what is beyond a corner is a mean.
        const int most = is_corner ? 10 : 6;
        const Rgb& shown = pixels[size_t{j} * kTileSide + i];
        ASSERT_NEAR(shown[0], wanted.red, most) << nameOf(tile) << ' ' << i << ' ' << j;
        ASSERT_NEAR(shown[1], wanted.green, most) << nameOf(tile) << ' ' << i << ' ' << j;
        ASSERT_NEAR(shown[2], wanted.blue, most) << nameOf(tile) << ' ' << i << ' ' << j;
        ++on_face[t.face], gutters += t.beyond(side) == 1 ? 1 : 0, corners += is_corner ? 1 : 0;
      }
  });
  for (const int count : on_face) EXPECT_GT(count, 1000);
  EXPECT_GT(gutters, 500);
  EXPECT_GT(corners, 10);
  // As a viewer asks, by direction.
  const auto shown = TilePicture::of(scene);
  const proto::FrameTransform transform(scene->frame());
  Rng rng(seed);
  for (int i = 0; i < 2000; ++i) {
    glm::dvec3 d(rng.uniform(-1, 1), rng.uniform(-1, 1), rng.uniform(-1, 1));
    if (i % 4 == 0) d = {rng.uniform(-1e-3, 1e-3), rng.uniform(-1e-3, 1e-3), i % 8 == 0 ? 1 : -1};  // poles
    if (i % 4 == 1) d = {1, i % 8 == 1 ? 1 : -1, 1 + rng.uniform(-1e-3, 1e-3)};                     // corners
    if (i % 4 == 2) d = {-1, rng.uniform(-1e-6, 1e-6), rng.uniform(-1, 1)};                         // antimeridian
    const auto at = transform.toLattice(transform.spheroid().position(d, 0));
    const auto colour = shown->at({at.x, at.y}, 0);
    ASSERT_TRUE(colour);
    const Rgba wanted = colourOf(d);
    ASSERT_NEAR(colour->x, wanted.red, 6);
    ASSERT_NEAR(colour->y, wanted.green, 6);
    ASSERT_NEAR(colour->z, wanted.blue, 6);
  }
  const TilesReport report = verifyTiles(*scene, 2);
  EXPECT_EQ(report.faults, 0u) << (report.first_faults.empty() ? "" : report.first_faults.front());
}

// The source itself, without a codec: what is beyond a side is a texel of the face there, to the bit.
TEST_F(GlobeTiles, GuttersOfPicturesAreTheNeighboursTexels) {
  const Painted picture(0.01, 0.01, {1, 0, 0});
  const proto::TileLayer layer = globeImageryLayer(picture, 128);
  const GlobeImagerySource source(picture, layer);
  const int64_t side = layer.widthAt(0);
  const auto read = [&](const FaceTexel& t) {
    EXPECT_EQ(t.beyond(side), 0);
    return source.at(0, t.face, static_cast<uint32_t>(t.x), static_cast<uint32_t>(t.y));
  };
  for (uint32_t face = 0; face < 6; ++face)
    for (int64_t i = 0; i < side; ++i)
      for (int64_t d = 1; d <= int64_t{kTileGutter}; ++d) {
        EXPECT_EQ(source.beyond(0, {face, side - 1 + d, i}, read),
                  read(foldedOver(FaceTexel{face, side - 1 + d, i}, side)));
        EXPECT_EQ(source.beyond(0, {face, i, -d}, read), read(foldedOver(FaceTexel{face, i, -d}, side)));
      }
  // In a corner all three faces read the same there: the mean of the four texels about it.
  const auto atCorner = [&](uint32_t face, bool east, bool north) {
    const int64_t x = east ? side - 1 : 0, y = north ? side - 1 : 0, bx = east ? side : -1, by = north ? side : -1;
    glm::dvec3 sum(0);
    for (const FaceTexel& t : {FaceTexel{face, x, y}, {face, bx, y}, {face, x, by}, {face, bx, by}}) {
      const LinearTexel c = t.beyond(side) == 0 ? read(t) : source.beyond(0, t, read);
      sum += glm::dvec3(c.red, c.green, c.blue);
    }
    return 0.25 * sum;
  };
  for (uint32_t face = 0; face < 6; ++face)
    for (const bool east : {false, true})
      for (const bool north : {false, true})
        for (uint32_t other = 0; other < 6; ++other)
          for (const bool other_east : {false, true})
            for (const bool other_north : {false, true}) {
              const auto corner = [&](uint32_t f, bool e, bool n) {
                return directionOf({f, e ? 1.0 : 0.0, n ? 1.0 : 0.0}, 1);
              };
              if (glm::distance(corner(face, east, north), corner(other, other_east, other_north)) > 1e-9) continue;
              EXPECT_LT(glm::distance(atCorner(face, east, north), atCorner(other, other_east, other_north)), 2);
            }
}

TEST_F(GlobeTiles, AreFinerWhereAPictureIs) {
  const glm::dvec3 about(1, 0.98, 0.3);  // beside an edge
  const Painted picture(0.01, 0.0005, about);
  const auto scene = make(picture, 7, 0);
  const TileTable& tiles = scene->tiles();
  const proto::TileLayer& layer = tiles.layers()[1];
  uint64_t places = 0;
  for (uint32_t level = 0; level < layer.levels(); ++level) places += 6 * layer.tilesX(level) * layer.tilesY(level);
  uint64_t stored = 0, all = 0;
  tiles.forEach(1, [&](const TileId& tile) {
    ++all;
    if (!tiles.bounds(tile)) return;
    ++stored;
    EXPECT_TRUE(layer.isCoarsest(tile) || tiles.bounds(tile.parent()));
  });
  EXPECT_LT(all, places / 4);
  EXPECT_GT(stored, 6u);
  EXPECT_EQ(verifyTiles(*scene, 2).faults, 0u);
}

// Heights of the finest level are those of the ground within a step, also in gutters, as the face's coordinates go on.
TEST_F(GlobeTiles, ReliefIsTheGroundAlsoBeyondSides) {
  const Painted picture(0.05, 0.05, {1, 0, 0});
  const auto scene = make(picture, 8, 0);
  const TileTable& tiles = scene->tiles();
  const proto::TileLayer& layer = tiles.layers()[0];
  ASSERT_EQ(layer.width, 256u);
  const proto::Spheroid spheroid(scene->frame().semi_major_m, scene->frame().semiMinor());
  std::vector<int32_t> steps(proto::kTileTexels);
  int checked = 0;
  tiles.forEach(0, [&](const TileId& tile) {
    if (tile.level > 0) return;
    ASSERT_TRUE(proto::decodeRelief(tiles.bytes(tile), steps).ok());
    for (uint32_t j = 0; j < kTileSide; j += 2)
      for (uint32_t i = 0; i < kTileSide; i += 2) {
        const FaceTexel t = texelOf(layer, tile, i, j);
        const int64_t side = layer.width;
        if (t.x >= side + kTileGutter || t.y >= side + kTileGutter) continue;
        const FacePlace own{t.face, static_cast<double>(t.x) + 0.5, static_cast<double>(t.y) + 0.5};
        const double wanted =
            test::globeHills(seed, glm::normalize(spheroid.position(directionOf(own, static_cast<double>(side)), 0)));
        // Hills bend by some metres within a square of samples.
        ASSERT_NEAR(steps[size_t{j} * kTileSide + i] * layer.stepAt(0), wanted, 0.5 * layer.stepAt(0) + 3)
            << nameOf(tile) << ' ' << i << ' ' << j;
        ++checked;
      }
  });
  EXPECT_GT(checked, 90'000);
  const TilesReport report = verifyTiles(*scene, 2);
  EXPECT_EQ(report.faults, 0u) << (report.first_faults.empty() ? "" : report.first_faults.front());
  EXPECT_LT(report.layers[0].rms_rad, 0.05);
}

TEST_F(GlobeTiles, ReliefIsFineWhereThereAreNodes) {
  const Painted picture(0.05, 0.05, {1, 0, 0});
  const auto scene = make(picture, 10, 4);
  const TileTable& tiles = scene->tiles();
  const proto::TileLayer& layer = tiles.layers()[0];
  uint64_t finest = 0;
  tiles.forEach(0, [&](const TileId& tile) { finest += tile.level == 0 && tiles.bounds(tile) ? 1 : 0; });
  EXPECT_GT(finest, 0u);
  EXPECT_LT(finest, 30u);
  EXPECT_EQ(layer.tilesX(0), 5u);
  const TilesReport report = verifyTiles(*scene, 2);
  EXPECT_EQ(report.faults, 0u) << (report.first_faults.empty() ? "" : report.first_faults.front());
}

}  // namespace
}  // namespace foreland::terrain
