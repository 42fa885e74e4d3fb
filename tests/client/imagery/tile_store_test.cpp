// The tiles that a client holds: the server's rule, and what a viewer says of them when it comes back.
#include "client/imagery/tile_store.h"

#include <gtest/gtest.h>

#include <random>

#include "tests/support/seed.h"

namespace foreland::test {
namespace {

proto::TileLayer layerOf(uint32_t side) {
  proto::TileLayer layer;
  layer.width = layer.height = side;
  layer.step_m = 1;
  return layer;
}

proto::TileMessage tileOf(const proto::TileId& tile, size_t bytes) { return {tile, {0, 1}, Bytes(bytes, uint8_t{7})}; }

TEST(TileStore, HoldsWhatTheServerThinksThatItHolds) {
  std::mt19937_64 random(randomSeed());
  client::TileStore store;
  store.enter({layerOf(10'000)}, 50'000);
  proto::TileMemory server(50'000);
  for (int i = 0; i < 2000; ++i) {
    const proto::TileId tile{0, static_cast<uint8_t>(random() % 2), static_cast<uint32_t>(random() % 20),
                             static_cast<uint32_t>(random() % 20)};
    const size_t bytes = random() % 4000;
    ASSERT_TRUE(store.add(tileOf(tile, bytes)).ok());
    server.add(tile, static_cast<uint32_t>(bytes), [](const proto::TileId&) {});
    ASSERT_EQ(store.count(), server.count());
    ASSERT_EQ(store.bytes(), server.bytes());
    ASSERT_NE(store.find(tile), nullptr);
    ASSERT_EQ(store.find(tile)->coded.size(), bytes);
  }
  for (const proto::TileId& tile : store.held().tiles) {
    EXPECT_TRUE(server.has(tile));
    EXPECT_NE(store.find(tile), nullptr);
  }
  EXPECT_EQ(store.held().tiles.size(), server.count());
}

TEST(TileStore, KeepsTheNewestWhenALaterConnectionAllowsLess) {
  client::TileStore store;
  store.enter({layerOf(10'000)}, 10'000);
  for (uint32_t x = 0; x < 10; ++x) ASSERT_TRUE(store.add(tileOf({0, 0, x, 0}, 1000)).ok());
  store.reenter(4500);
  ASSERT_EQ(store.count(), 4u);
  EXPECT_EQ(store.held().tiles.front().x, 6u);
  EXPECT_EQ(store.find({0, 0, 5, 0}), nullptr);
}

// The next keyframe's statement comes before that keyframe, while the last one is still the newest.
TEST(TileStore, KnowsWhatIsStatedOfEitherOfTheLastTwoKeyframes) {
  client::TileStore store;
  store.enter({layerOf(300)}, 10'000);
  EXPECT_EQ(store.statementOf(100), nullptr);
  store.add(proto::TileStatement{4, {8, 8}});
  EXPECT_EQ(store.statementOf(3), nullptr);
  store.add(proto::TileStatement{7, {2, 3}});
  for (const uint32_t keyframe : {4u, 6u}) EXPECT_EQ(store.statementOf(keyframe)->keyframe, 4u);
  for (const uint32_t keyframe : {7u, 100u}) EXPECT_EQ(store.statementOf(keyframe)->keyframe, 7u);
  EXPECT_EQ(store.statementOf(100)->texel_px[1], 3);
  store.reenter(10'000);
  EXPECT_EQ(store.statementOf(100), nullptr) << "of the connection before";
}

TEST(TileStore, RefusesTilesThatTheSceneDoesNotHave) {
  client::TileStore store;
  store.enter({layerOf(300)}, 10'000);
  for (const proto::TileId& tile : {proto::TileId{1, 0, 0, 0}, proto::TileId{0, 5, 0, 0}, proto::TileId{0, 0, 2, 0}}) {
    const Status status = store.add(tileOf(tile, 10));
    ASSERT_FALSE(status.ok());
    EXPECT_NE(status.error().message.find("a tile that the scene does not have"), std::string::npos);
  }
  EXPECT_EQ(store.count(), 0u);
}

}  // namespace
}  // namespace foreland::test
