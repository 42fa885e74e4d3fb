// Tiles of relief beside keyframes, server and client together in virtual time.
#include <gtest/gtest.h>

#include <cmath>

#include "base/rng.h"
#include "server/imagery/tile_sender.h"
#include "sim/client_drape.h"
#include "sim/world.h"
#include "tests/support/height_field.h"
#include "tests/support/scene.h"
#include "tests/support/seed.h"
#include "tests/support/texel_on_screen.h"

namespace foreland::test {
namespace {

using sim::ClientOptions;
using sim::World;

std::shared_ptr<const terrain::Scene> manyTiles() {
  static const auto scene = makeScene(1001, 760, 17);
  return scene;
}

ClientOptions flyingOver(const terrain::Scene& scene, const char* tour, double seconds) {
  ClientOptions c = sim::onKnownTour(scene, tour, seconds);
  c.request.lens = {1.0471975511965976, 640, 400};
  c.request.relief = true;
  return c;
}

// Straight down, along the scene's diagonal: what is needed changes all the time.
ClientOptions lookingDown(const terrain::Scene& scene, double seconds) {
  ClientOptions c = flyingOver(scene, "survey", seconds);
  const proto::FrameTransform frame(scene.frame());
  const proto::GridShape& shape = scene.grid().shape();
  for (size_t i = 0; i < c.path.poses.size(); ++i) {
    const double share = static_cast<double>(i) / static_cast<double>(c.path.poses.size() - 1);
    c.path.poses[i] = {frame.toScene(proto::LatticePosition{share * shape.samples_x, share * shape.samples_y, 3500}),
                       glm::dquat(1, 0, 0, 0)};
  }
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
  ClientOptions small = lookingDown(*scene, 12);
  small.request.tile_bytes = 100'000;
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
  EXPECT_LE(world.viewer(1).tiles().bytes(), 100'000u);
  for (size_t i = 0; i < 2; ++i) EXPECT_EQ(heldBy(world.viewer(i)), heldBy(world.session(i)));
  EXPECT_EQ(world.viewer(2).tiles().received(), 0u);
  // Sections do not depend on tiles.
  EXPECT_EQ(world.session(0).section(), world.session(2).section());
}

// What is drawn in a frame at a lattice position of a layer: the level of its texels, between two levels while it
// fades; nothing where no tile is.
std::optional<double> levelDrawn(const sim::DrawnTiles& drawn, const proto::TileLayer& layer, double x, double y) {
  for (uint8_t level = 0; level < layer.levels(); ++level) {
    const glm::dvec2 at = (glm::dvec2(x, y) - layer.origin) / (proto::kTilePayload * layer.texelAt(level));
    const auto found =
        drawn.find(proto::TileId{0, level, static_cast<uint32_t>(at.x), static_cast<uint32_t>(at.y)}.key());
    if (found != drawn.end()) return level + double{found->second};
  }
  return std::nullopt;
}

// Texels that the client draws, wherever the ground is seen.
TEST(Tiles, WhatIsStatedHoldsInEveryFrame) {
  const auto scene = manyTiles();
  const server::Hierarchy hierarchy(scene);
  const HeightField field(hierarchy);
  const proto::FrameTransform frame(scene->frame());
  const proto::TileLayer& layer = scene->tiles().layers()[0];
  const auto positionAt = [&](double x, double y) {
    return frame.toScene(proto::LatticePosition{x, y, field.at(x, y)});
  };
  Rng rng(randomSeed());
  for (const double bytes_per_second : {0.0, 40e3}) {
    World world(scene, {}, Duration::milliseconds(4), 1);
    ClientOptions client = flyingOver(*scene, "canyon", 12);
    client.down.bytes_per_second = bytes_per_second;
    world.addClient(client);
    sim::ClientDrape drape(proto::TileContent::kRelief);
    uint64_t frames = 0, judged = 0, coarse = 0, sharp = 0;
    const auto judge = [&](const proto::View& view, const sim::DrawnTiles& drawn, double x, double y,
                           double stated_px) {
      if (!field.isClear(view.pose.eye, positionAt(x, y), 1)) return;
      const auto level = levelDrawn(drawn, layer, x, y);
      ASSERT_TRUE(level);
      const auto size_px = texelOnScreen(positionAt, view, x, y, layer.texelAt(0) * std::exp2(*level), 0.01);
      if (!size_px) return;
      ++judged;
      if (*level == 0 || *size_px <= server::TileSender::kTexel_px) ++sharp;
      if (*level == 0) return;
      coarse += *size_px > server::TileSender::kTexel_px ? 1 : 0;
      EXPECT_LE(*size_px, 1.01 * stated_px) << "frame " << frames << " at " << x << ", " << y;
    };
    world.on_keyframe = [&](size_t, const sim::ArrivedKeyframe&) { drape.onKeyframe(world.viewer(0)); };
    world.on_frame = [&](size_t, const client::FrameView& frame_view, Time) {
      const double stated_px = drape.texelPx(frame_view.mesh_version);
      const sim::DrawnTiles drawn = drape.drawn(frame_view.mesh_version, frame_view.weight);
      if (++frames % 3 != 0 || !std::isfinite(stated_px)) return;
      const proto::View view{frame_view.pose, client.request.lens, 1};
      const proto::LatticePosition eye = frame.toLattice(view.pose.eye);
      for (int k = 0; k < 500; ++k) {
        // The nearer the more.
        const double far = 800 * std::pow(rng.uniform(0, 1), 2), heading = rng.uniform(-3.15, 3.15);
        const double x = eye.x + far * std::cos(heading), y = eye.y + far * std::sin(heading);
        const bool is_inside = x >= 0 && y >= 0 && x < layer.width - 1.1 && y < layer.height - 1.1;
        if (is_inside && project(view, positionAt(x, y))) judge(view, drawn, x, y, stated_px);
      }
    };
    world.run(Time::seconds(11));
    EXPECT_EQ(world.report(), "");
    EXPECT_GT(frames, 500u);
    EXPECT_GT(judged, 500u);
    if (bytes_per_second > 0)
      EXPECT_GT(coarse, 0u);
    else
      EXPECT_GT(sharp, judged * 9 / 10);
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
    world.on_keyframe = [&](size_t, const sim::ArrivedKeyframe& k) { lateness.push_back(k.lateness); };
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
