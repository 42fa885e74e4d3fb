// The section of tiles: what is written is read, and damage ends in an error or in tiles that are not there.
#include "terrain/store/tables/tile_table.h"

#include <gtest/gtest.h>

#include <array>
#include <cstddef>
#include <cstring>
#include <map>

#include "base/rng.h"
#include "terrain/store/tables/tile_section.h"
#include "tests/support/files.h"
#include "tests/support/forged_scene.h"
#include "tests/support/scene.h"
#include "tests/support/seed.h"

namespace foreland::terrain {
namespace {

proto::TileLayer relief(uint32_t width, uint32_t height) {
  return {.width = width, .height = height, .origin = {-0.5, -0.5}, .texel = 1, .step_m = 0.5, .attribution = {}};
}
proto::TileLayer imagery(uint32_t width, uint32_t height) {
  return {.content = proto::TileContent::kImagery,
          .coding = proto::TileCoding::kWebP,
          .width = width,
          .height = height,
          .origin = {-0.5, -0.5},
          .texel = 0.25,
          .step_m = 0,
          .attribution = "made by hand"};
}

// Records, aligned as in a mapped file.
struct Aligned {
  std::vector<uint64_t> words;
  size_t size;
  explicit Aligned(size_t n) : words((n + 7) / 8), size(n) {}
  uint8_t* data() { return reinterpret_cast<uint8_t*>(words.data()); }
  ByteSpan span() const { return {reinterpret_cast<const uint8_t*>(words.data()), size}; }
};

Aligned bytesOf(const TileSection& section) {
  Aligned out(section.bytes());
  const auto put = [&](uint64_t offset, ByteSpan what) {
    std::copy(what.begin(), what.end(), out.data() + offset);
    return Status();
  };
  EXPECT_TRUE(section.write(put).ok());
  return out;
}

class Tiles : public testing::Test {
 protected:
  test::TemporaryFolder folder;
  Rng rng{test::randomSeed()};
  struct Tile {
    Bytes bytes;
    proto::TileBounds bounds;
    float detail;
  };
  std::map<uint64_t, Tile> added;

  // All of a layer's tiles that `isStored` says, the coarsest always; in an order of chance.
  template <class IsStored>
  void fill(TileSection& section, uint8_t layer, const IsStored& isStored) {
    std::vector<proto::TileId> ids;
    const proto::TileLayer& l = section.layer(layer);
    for (uint8_t level = 0; level < l.levels(); ++level)
      for (uint32_t y = 0; y < l.tilesY(level); ++y)
        for (uint32_t i = 0; i < l.faces() * l.tilesX(level); ++i) {
          const uint32_t x = l.xOf(level, i / l.tilesX(level), i % l.tilesX(level));
          if (const proto::TileId id{layer, level, x, y}; isStored(id)) ids.push_back(id);
        }
    for (size_t i = ids.size(); i > 1; --i) std::swap(ids[i - 1], ids[rng.below(i)]);
    for (const proto::TileId& id : ids) {
      Tile tile{Bytes(1 + rng.below(300)), {}, 0.25F};
      for (uint8_t& byte : tile.bytes) byte = static_cast<uint8_t>(rng.next());
      tile.bounds = {-static_cast<float>(id.x), 5.5F, {1, -2, static_cast<int8_t>(id.level)}, 9};
      EXPECT_TRUE(section.add(id, tile.bytes, tile.bounds, tile.detail).ok());
      added[id.key()] = std::move(tile);
    }
  }
  TileSection twoLayers() {
    auto section = TileSection::create(folder / "a.fls");
    EXPECT_TRUE(section.ok());
    TileSection tiles = std::move(section).value();
    fill(tiles, tiles.addLayer(relief(600, 251)), [](const proto::TileId&) { return true; });
    fill(tiles, tiles.addLayer(imagery(1500, 900)), [](const proto::TileId& id) { return id.level > 0 || id.x < 2; });
    return tiles;
  }
};

constexpr uint32_t kFaceSteps = 512;

proto::TileLayer onGlobe(proto::TileLayer layer, uint32_t width) {
  layer.width = layer.height = width;
  layer.origin = {0, 0};
  layer.face_steps = kFaceSteps;
  layer.texel = static_cast<double>(kFaceSteps) / width;
  return layer;
}

class TilesOfGlobes : public Tiles {
 protected:
  // Of the imagery's finest level there is a part of two faces.
  TileSection globe() {
    TileSection tiles = std::move(TileSection::create(folder / "a.fls").value());
    fill(tiles, tiles.addLayer(onGlobe(relief(512, 512), 512)), [](const proto::TileId&) { return true; });
    const uint8_t index = tiles.addLayer(onGlobe(imagery(4000, 4000), 4000));
    const proto::TileLayer& l = tiles.layer(index);
    fill(tiles, index, [&](const proto::TileId& id) {
      const uint32_t face = l.faceOf(id);
      return l.isCoarsest(id) || (face == 2 && id.level > 1) || (face == 5 && l.columnOf(id) >> (4 - id.level) == 0);
    });
    return tiles;
  }
};

TEST_F(TilesOfGlobes, AreFoundOnAllFacesAndNowhereElse) {
  const TileSection section = globe();
  const Aligned bytes = bytesOf(section);
  const auto table = TileTable::read(bytes.span(), kFaceSteps);
  ASSERT_TRUE(table.ok()) << table.error().message;
  EXPECT_EQ(table->layers()[1], section.layer(1));
  std::array<size_t, 6> on_face{};
  size_t absent = 0;
  for (uint8_t layer = 0; layer < 2; ++layer) {
    const proto::TileLayer& l = table->layers()[layer];
    for (uint8_t level = 0; level < l.levels(); ++level)
      for (uint32_t x = 0; x < 6u << l.faceBits(level); ++x)
        for (uint32_t y = 0; y < l.tilesY(level); ++y) {
          const proto::TileId id{layer, level, x, y};
          if (!l.has(id)) continue;
          const auto it = added.find(id.key());
          ASSERT_EQ(table->bounds(id).has_value(), it != added.end()) << nameOf(id);
          if (it == added.end()) {
            ++absent;
            continue;
          }
          const ByteSpan coded = table->bytes(id);
          ASSERT_EQ(Bytes(coded.begin(), coded.end()), it->second.bytes);
          ASSERT_EQ(*table->bounds(id), it->second.bounds);
          ++on_face[l.faceOf(id)];
        }
  }
  for (const size_t count : on_face) EXPECT_GT(count, 10u);
  EXPECT_GT(absent, 1000u);
  size_t seen = 0;
  for (uint8_t layer = 0; layer < 2; ++layer)
    table->forEach(layer, [&](const proto::TileId& id) { seen += table->bounds(id) ? 1 : 0; });
  EXPECT_EQ(seen, added.size());
  table->check([](const std::string& what) { ADD_FAILURE() << what; });
}

TEST_F(TilesOfGlobes, DamageIsAnErrorOrFoundOrHarmless) {
  const Aligned sound = bytesOf(globe());
  const uint64_t directory = sizeof(TileSectionStart) + 2 * sizeof(StoredLayer);
  for (int i = 0; i < 1000; ++i) {
    Aligned bytes = sound;
    // Numbers of children among them.
    const uint64_t entry = directory + rng.below(60) * sizeof(StoredTile);
    const uint32_t number = static_cast<uint32_t>(rng.below(300));
    std::memcpy(bytes.data() + entry + offsetof(StoredTile, children), &number, sizeof(number));
    if (rng.below(2)) bytes.data()[rng.below(bytes.size)] = static_cast<uint8_t>(rng.next());
    const auto table = TileTable::read(bytes.span(), kFaceSteps);
    if (!table.ok()) continue;
    for (uint8_t layer = 0; layer < table->layers().size(); ++layer)
      table->forEach(layer, [&](const proto::TileId& id) {
        const ByteSpan coded = table->bytes(id);
        if (coded.empty()) return;
        ASSERT_GE(coded.data(), bytes.span().data());
        ASSERT_LE(coded.data() + coded.size(), bytes.span().data() + bytes.size);
      });
    table->check([](const std::string&) {});
  }
}

TEST_F(Tiles, GiveBackWhatWasAdded) {
  const TileSection section = twoLayers();
  const Aligned bytes = bytesOf(section);
  const auto table = TileTable::read(bytes.span());
  ASSERT_TRUE(table.ok()) << table.error().message;
  ASSERT_EQ(table->layers().size(), 2u);
  EXPECT_EQ(table->layers()[0], relief(600, 251));
  EXPECT_EQ(table->layers()[1], imagery(1500, 900));
  size_t seen = 0;
  for (uint8_t layer = 0; layer < 2; ++layer)
    table->forEach(layer, [&](const proto::TileId& id) {
      const auto it = added.find(id.key());
      ASSERT_EQ(table->bounds(id).has_value(), it != added.end());
      const ByteSpan coded = table->bytes(id);
      EXPECT_EQ(coded.empty(), it == added.end());
      if (it == added.end()) return;
      ++seen;
      EXPECT_EQ(Bytes(coded.begin(), coded.end()), it->second.bytes);
      EXPECT_EQ(*table->bounds(id), it->second.bounds);
      EXPECT_EQ(table->detail(id), it->second.detail);
    });
  EXPECT_EQ(seen, added.size());
  table->check([](const std::string& what) { ADD_FAILURE() << what; });
}

TEST_F(Tiles, ASectionThatIsCutShortIsRefusedOrItsTilesAreMissed) {
  const Aligned bytes = bytesOf(twoLayers());
  for (size_t size = 1; size < bytes.size; size += 1 + size / 30) {
    const auto table = TileTable::read(bytes.span().first(size));
    if (!table.ok()) continue;
    size_t faults = 0;
    table->check([&](const std::string&) { ++faults; });
    EXPECT_GT(faults, 0u) << size;
  }
}

// Whatever the bytes are, what the table gives lies within them and is sane.
TEST_F(Tiles, AnyBytesEndInAnErrorOrInTilesWithinThem) {
  const Aligned sound = bytesOf(twoLayers());
  for (int i = 0; i < 4000; ++i) {
    Aligned bytes = sound;
    for (uint64_t changes = 1 + rng.below(6); changes > 0; --changes)
      bytes.data()[rng.below(rng.below(2) ? 120 : bytes.size)] = static_cast<uint8_t>(rng.next());
    const auto table = TileTable::read(bytes.span());
    if (!table.ok()) continue;
    for (uint8_t layer = 0; layer < table->layers().size(); ++layer)
      table->forEach(layer, [&](const proto::TileId& id) {
        const auto bounds = table->bounds(id);
        const ByteSpan coded = table->bytes(id);
        ASSERT_EQ(bounds.has_value(), !coded.empty());
        if (!bounds) return;
        ASSERT_LE(bounds->lowest_m, bounds->highest_m);
        ASSERT_GE(coded.data(), bytes.span().data());
        ASSERT_LE(coded.data() + coded.size(), bytes.span().data() + bytes.size);
      });
    table->check([](const std::string&) {});
  }
}

TEST(SceneWithTiles, FilesOfVersion3AreReadAndHaveNone) {
  const test::TemporaryFolder folder;
  test::FormulaSource source(40, 25, test::hills(3));
  ASSERT_TRUE(buildScene(source, {folder / "new.fls"}).ok());
  std::vector<char> bytes = test::slurp(folder / "new.fls");
  FileHeader header = test::headerOf(bytes);
  ASSERT_GT(header.tiles.bytes, 0u);
  header.version = 3;
  test::sealScene(bytes, header);
  test::spit(folder / "lies.fls", bytes);
  EXPECT_FALSE(Scene::open(folder / "lies.fls").ok());
  // The sections before the tiles as they are, then the table of checksums.
  const auto new_scene = Scene::open(folder / "new.fls");
  const FileLayout layout =
      FileLayout::of((*new_scene)->grid().shape(), (*new_scene)->pages(), {.text = header.sections[kText].bytes});
  header.tiles = {};
  header.file_bytes = layout.file_bytes;
  header.sections[kChecksums] = layout.sections[kChecksums];
  bytes.resize(layout.file_bytes);
  std::fill(bytes.begin() + static_cast<ptrdiff_t>(layout.sections[kChecksums].offset), bytes.end(), 0);
  test::sealScene(bytes, header);
  test::spit(folder / "old.fls", bytes);
  const auto scene = Scene::open(folder / "old.fls");
  ASSERT_TRUE(scene.ok()) << scene.error().message;
  EXPECT_TRUE((*scene)->tiles().layers().empty());
  EXPECT_EQ((*scene)->height(proto::NodeId::at(12, 8)), (*new_scene)->height(proto::NodeId::at(12, 8)));
  header.version = 2;
  test::sealScene(bytes, header);
  test::spit(folder / "older.fls", bytes);
  EXPECT_FALSE(Scene::open(folder / "older.fls").ok());
}

}  // namespace
}  // namespace foreland::terrain
