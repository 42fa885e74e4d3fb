// What a client holds of tiles, against a list; and names and levels of tiles.
#include "proto/imagery/tile_memory.h"

#include <gtest/gtest.h>

#include <list>
#include <vector>

#include "base/rng.h"
#include "tests/support/seed.h"

namespace foreland::proto {
namespace {

TEST(TileMemory, HoldsTheNewestThatFit) {
  Rng rng(test::randomSeed());
  TileMemory memory(10000);
  struct Each {
    uint64_t key;
    uint32_t bytes;
  };
  std::list<Each> expected;  // the oldest first
  size_t dropped = 0;
  for (int i = 0; i < 20000; ++i) {
    const TileId tile{0, static_cast<uint8_t>(rng.below(3)), static_cast<uint32_t>(rng.below(20)),
                      static_cast<uint32_t>(rng.below(20))};
    const uint32_t bytes = static_cast<uint32_t>(rng.below(i % 100 == 0 ? 30000 : 400));
    std::vector<uint64_t> drops, expected_drops;
    memory.add(tile, bytes, [&](const TileId& t) { drops.push_back(t.key()); });
    expected.remove_if([&](const Each& e) { return e.key == tile.key(); });
    expected.push_back({tile.key(), bytes});
    const auto sum = [&] {
      uint64_t total = 0;
      for (const Each& e : expected) total += e.bytes;
      return total;
    };
    for (; expected.size() > 1 && sum() > 10000; expected.pop_front()) expected_drops.push_back(expected.front().key);
    ASSERT_EQ(drops, expected_drops);
    dropped += drops.size();
    ASSERT_EQ(memory.count(), expected.size());
    ASSERT_EQ(memory.bytes(), sum());
    auto next = expected.begin();
    memory.visit([&](const TileId& t, uint32_t held) {
      ASSERT_TRUE(memory.has(t));
      ASSERT_EQ(t.key(), next->key);
      ASSERT_EQ(held, next++->bytes);
    });
    ASSERT_EQ(next, expected.end());
  }
  EXPECT_GT(dropped, 1000u);
}

TEST(TileMemory, HoldsNoMoreTilesThanAllowed) {
  TileMemory memory;
  size_t drops = 0;
  for (uint32_t i = 0; i < kMaxTilesHeld + 10; ++i) memory.add({0, 0, i, 0}, 1, [&](const TileId&) { ++drops; });
  EXPECT_EQ(memory.count(), kMaxTilesHeld);
  EXPECT_EQ(drops, 10u);
  EXPECT_FALSE(memory.has({0, 0, 9, 0}));
  EXPECT_TRUE(memory.has({0, 0, 10, 0}));
}

TEST(Tile, KeysTellTilesApart) {
  Rng rng(test::randomSeed());
  for (int i = 0; i < 1000; ++i) {
    const TileId tile{static_cast<uint8_t>(rng.below(2)), static_cast<uint8_t>(rng.below(20)),
                      static_cast<uint32_t>(rng.below(1 << 24)), static_cast<uint32_t>(rng.below(1 << 24))};
    EXPECT_EQ(TileId::of(tile.key()), tile);
  }
}

TEST(Tile, TheLastLevelIsTheFirstThatIsOneTile) {
  for (const uint32_t side : {1u, 247u, 248u, 249u, 495u, 496u, 497u, 992u, 993u, 3601u, 8193u, kMaxLayerSide}) {
    TileLayer layer;
    layer.width = side, layer.height = 1;
    const uint32_t last = layer.levels() - 1;
    EXPECT_EQ(layer.tilesX(last), 1u) << side;
    EXPECT_TRUE(last == 0 || layer.tilesX(last - 1) > 1) << side;
  }
}

}  // namespace
}  // namespace foreland::proto
