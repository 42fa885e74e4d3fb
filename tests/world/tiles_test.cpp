// Tiles of relief beside keyframes, server and client together in virtual time.
#include <gtest/gtest.h>

#include <cmath>

#include "bench/world/world.h"
#include "proto/imagery/tile_selection.h"
#include "server/imagery/tile_sender.h"
#include "tests/support/scene.h"
#include "tests/support/seed.h"

namespace foreland::test {
namespace {

using bench::ClientOptions;
using bench::World;

std::shared_ptr<const terrain::Scene> manyTiles() {
  static const auto scene = makeScene(1001, 760, 17);
  return scene;
}

ClientOptions flyingOver(const terrain::Scene& scene, const char* tour, double seconds) {
  ClientOptions c = bench::onKnownTour(scene, tour, seconds);
  c.request.lens = {1.0471975511965976, 640, 400};
  c.request.relief = true;
  return c;
}

std::vector<uint64_t> heldBy(const client::Viewer& viewer) {
  std::vector<uint64_t> keys;
  for (const proto::TileId& tile : viewer.tiles().held().tiles) keys.push_back(tile.key());
  return keys;
}
std::vector<uint64_t> heldBy(const server::Session& session) {
  std::vector<uint64_t> keys;
  session.tiles()->held().visit([&](const proto::TileId& tile, uint32_t) { keys.push_back(tile.key()); });
  return keys;
}

TEST(Tiles, NothingIsSentTwiceAndTheServerKnowsWhatIsHeld) {
  const auto scene = manyTiles();
  World world(scene, {}, Duration::milliseconds(4), 1);
  world.addClient(flyingOver(*scene, "survey", 12));
  ClientOptions small = flyingOver(*scene, "survey", 12);
  small.request.tile_bytes = 60'000;
  world.addClient(small);
  ClientOptions none = flyingOver(*scene, "survey", 12);
  none.request.relief = false;
  world.addClient(none);
  world.run(Time::seconds(11.95));
  EXPECT_EQ(world.report(), "");
  const client::TileStore& held = world.viewer(0).tiles();
  EXPECT_GT(held.count(), 8u);
  EXPECT_EQ(held.received(), held.count());
  EXPECT_GT(world.viewer(1).tiles().received(), world.viewer(1).tiles().count()) << "some were dropped";
  EXPECT_LE(world.viewer(1).tiles().bytes(), 60'000u);
  for (size_t i = 0; i < 2; ++i) EXPECT_EQ(heldBy(world.viewer(i)), heldBy(world.session(i)));
  EXPECT_EQ(world.viewer(2).tiles().received(), 0u);
  // Sections do not depend on tiles.
  EXPECT_EQ(world.session(0).section(), world.session(2).section());
}

// Of the tiles that the camera needs those that the client lacks are shown by their parents, and these are stated.
TEST(Tiles, WhatIsStatedHoldsInEveryFrame) {
  const auto scene = manyTiles();
  const proto::FrameTransform frame(scene->frame());
  for (const double bytes_per_second : {0.0, 40e3}) {
    World world(scene, {}, Duration::milliseconds(4), 1);
    ClientOptions client = flyingOver(*scene, "canyon", 12);
    client.down.bytes_per_second = bytes_per_second;
    world.addClient(client);
    uint64_t frames = 0, coarse = 0;
    std::vector<proto::SelectedTile> needed;
    world.on_frame = [&](size_t, const client::FrameView& view, Time) {
      const auto& statement = world.viewer(0).tiles().statement();
      if (!statement || ++frames % 7 != 0) return;
      const proto::View here{view.pose, client.request.lens, 1};
      proto::selectTiles(
          scene->tiles().layers()[0], 0, frame, here, server::TileSender::kTexel_px, 10000,
          [&](const proto::TileId& tile) { return scene->tiles().bounds(tile); }, needed);
      const client::TileStore& held = world.viewer(0).tiles();
      for (const proto::SelectedTile& each : needed) {
        float shown_px = each.texel_px;
        proto::TileId tile = each.tile;
        for (; !held.find(tile) && tile.level + 1u < scene->tiles().layers()[0].levels(); tile = tile.parent())
          shown_px *= 2;
        if (!held.find(tile)) shown_px = HUGE_VALF;
        if (tile == each.tile) continue;
        ++coarse;
        EXPECT_LE(shown_px, 1.001f * statement->texel_px[0]) << "frame " << frames;
      }
    };
    world.run(Time::seconds(11));
    EXPECT_EQ(world.report(), "");
    EXPECT_GT(frames, 500u);
    EXPECT_TRUE(bytes_per_second == 0 || coarse > 0);
  }
}

TEST(Tiles, DoNotMakeKeyframesLate) {
  const auto scene = manyTiles();
  const auto worst = [&](bool with_tiles) {
    World world(scene, {}, Duration::milliseconds(4), 1);
    ClientOptions client = flyingOver(*scene, "canyon", 12);
    client.request.relief = with_tiles;
    client.down.bytes_per_second = 1.25e6;  // 10 Mbit/s
    world.addClient(client);
    std::vector<Duration> lateness;
    world.on_keyframe = [&](size_t, const bench::ArrivedKeyframe& k) { lateness.push_back(k.lateness); };
    world.run(Time::seconds(11));
    EXPECT_EQ(world.report(), "");
    std::sort(lateness.begin(), lateness.end());
    return lateness[lateness.size() * 99 / 100];
  };
  EXPECT_LE(worst(true), std::max(worst(false), Duration{}) + Duration::milliseconds(50));
}

TEST(Tiles, AreNotSentAgainAfterAConnectionWasLost) {
  const auto scene = manyTiles();
  World world(scene, {}, Duration::milliseconds(4), 1);
  world.addClient(flyingOver(*scene, "survey", 12));
  world.run(Time::seconds(5));
  world.loseConnection(0);
  world.run(Time::seconds(6));
  world.connectAgain(0);
  world.run(Time::seconds(11.95));
  EXPECT_EQ(world.report(), "");
  const client::TileStore& held = world.viewer(0).tiles();
  EXPECT_GT(held.count(), 8u);
  EXPECT_EQ(held.received(), held.count());
  EXPECT_EQ(heldBy(world.viewer(0)), heldBy(world.session(0)));
}

}  // namespace
}  // namespace foreland::test
