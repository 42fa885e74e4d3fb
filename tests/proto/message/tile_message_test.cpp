// Messages about tiles: what goes in comes out, and any other bytes end in an Error.
#include <gtest/gtest.h>

#include <cmath>

#include "base/rng.h"
#include "proto/message/message.h"
#include "tests/support/seed.h"

namespace foreland::proto {
namespace {

TileMessage someTile(Rng& rng) {
  TileMessage m{{static_cast<uint8_t>(rng.below(2)), static_cast<uint8_t>(rng.below(kMaxTileLevels)),
                 static_cast<uint32_t>(rng.below(1 << 24)), static_cast<uint32_t>(rng.below(1 << 24))},
                {static_cast<float>(rng.uniform(-500, 0)),
                 static_cast<float>(rng.uniform(0, 9000)),
                 {static_cast<int8_t>(rng.below(128)), static_cast<int8_t>(-int(rng.below(128))), 5},
                 static_cast<uint8_t>(rng.below(256))},
                Bytes(rng.below(300))};
  for (uint8_t& each : m.coded) each = static_cast<uint8_t>(rng.below(256));
  return m;
}

TEST(TileMessage, RoundTrips) {
  Rng rng(test::randomSeed());
  for (int i = 0; i < 1000; ++i) {
    const TileMessage sent = someTile(rng);
    const auto message = decodeServerMessage(encode(sent));
    ASSERT_TRUE(message.ok()) << message.error().message;
    const auto& got = std::get<TileMessage>(*message);
    EXPECT_EQ(got.tile, sent.tile);
    EXPECT_EQ(got.bounds, sent.bounds);
    EXPECT_EQ(got.coded, sent.coded);
  }
  TileStatement said{77, {1.5f, HUGE_VALF}};
  const auto got = std::get<TileStatement>(*decodeServerMessage(encode(said)));
  EXPECT_EQ(got.keyframe, 77u);
  EXPECT_EQ(got.texel_px, said.texel_px);
}

TEST(TileMessage, LayersAndTilesHeldRoundTrip) {
  Welcome sent;
  sent.shape = {1, 1, 1, 2, 2};
  sent.keyframe_interval = Duration::milliseconds(200);
  sent.corner_heights.resize(4);
  sent.centre_heights.resize(1);
  sent.tile_bytes = 12345;
  TileLayer relief{.width = 700, .height = 300, .origin = {-0.5, -0.5}, .texel = 1, .step_m = 0.5, .attribution = ""};
  TileLayer imagery{TileContent::kImagery, TileCoding::kWebP, 7000, 3000, {-0.5, -0.5}, 0.1, 0, "Somebody, 2020"};
  sent.tile_layers = {relief, imagery};
  const auto got = decodeServerMessage(encode(sent));
  ASSERT_TRUE(got.ok()) << got.error().message;
  EXPECT_EQ(std::get<Welcome>(*got).tile_layers, sent.tile_layers);
  EXPECT_EQ(std::get<Welcome>(*got).tile_bytes, 12345u);

  const HeldTiles held{{{0, 3, 5, 6}, {1, 0, 70000, 9}}};
  EXPECT_EQ(std::get<HeldTiles>(*decodeClientMessage(encode(held))).tiles, held.tiles);
  EXPECT_FALSE(decodeClientMessage(encode(HeldTiles{std::vector<TileId>(kMaxTilesHeld + 1)})).ok());
  EXPECT_FALSE(decodeClientMessage(encode(HeldTiles{{{2, 0, 0, 0}}})).ok());

  ViewRequest request;
  request.imagery = true;
  request.tile_bytes = 99;
  const auto asked = std::get<ViewRequest>(*decodeClientMessage(encode(request)));
  EXPECT_FALSE(asked.relief);
  EXPECT_TRUE(asked.imagery);
  EXPECT_EQ(asked.tile_bytes, 99u);
}

TEST(TileMessage, AbsurdLayersAreRefused) {
  const auto isTaken = [](const auto& change) {
    Welcome welcome;
    welcome.shape = {1, 1, 1, 2, 2};
    welcome.keyframe_interval = Duration::milliseconds(200);
    welcome.corner_heights.resize(4);
    welcome.centre_heights.resize(1);
    welcome.tile_layers.resize(1);
    TileLayer& layer = welcome.tile_layers.front();
    layer.width = layer.height = 10;
    layer.step_m = 1;
    change(welcome);
    return decodeServerMessage(encode(welcome)).ok();
  };
  const auto layerIs = [&](const auto& change) { return isTaken([&](Welcome& w) { change(w.tile_layers.front()); }); };
  EXPECT_TRUE(layerIs([](TileLayer&) {}));
  EXPECT_FALSE(isTaken([](Welcome& w) { w.tile_layers.push_back(w.tile_layers.front()); }));
  EXPECT_FALSE(layerIs([](TileLayer& l) { l.width = 0; }));
  EXPECT_FALSE(layerIs([](TileLayer& l) { l.height = kMaxLayerSide + 1; }));
  EXPECT_FALSE(layerIs([](TileLayer& l) { l.coding = TileCoding::kWebP; }));
  EXPECT_FALSE(layerIs([](TileLayer& l) { l.content = TileContent{7}; }));
  for (const double bad : {0.0, -1.0, 1e30, std::nan("")}) {
    EXPECT_FALSE(layerIs([&](TileLayer& l) { l.texel = bad; })) << bad;
    EXPECT_FALSE(layerIs([&](TileLayer& l) { l.step_m = bad; })) << bad;
  }
  for (const double bad : {1e30, std::nan("")}) EXPECT_FALSE(layerIs([&](TileLayer& l) { l.origin.x = bad; })) << bad;
}

TEST(TileMessage, AnyBytesEndInAValueOrAnError) {
  Rng rng(test::randomSeed());
  size_t taken = 0;
  for (int i = 0; i < 20000; ++i) {
    Bytes bytes = i % 3 ? encode(someTile(rng)) : encode(TileStatement{1, {1, 2}});
    if (rng.below(2)) bytes.resize(1 + rng.below(bytes.size()));
    for (uint64_t k = rng.below(4); k > 0; --k)
      bytes[rng.below(bytes.size())] ^= static_cast<uint8_t>(1 + rng.below(255));
    const auto message = decodeServerMessage(bytes);
    if (!message) continue;
    ++taken;
    if (const auto* tile = std::get_if<TileMessage>(&*message)) {
      EXPECT_LT(tile->tile.layer, kMaxTileLayers);
      EXPECT_LT(tile->tile.level, kMaxTileLevels);
      EXPECT_LE(tile->bounds.lowest_m, tile->bounds.highest_m);
    }
  }
  EXPECT_GT(taken, 100u);
  EXPECT_LT(taken, 19000u);
}

}  // namespace
}  // namespace foreland::proto
