// Tiles pulled as CesiumJS does: the pyramid, the client, and the comparison with our own stream.
#include <gtest/gtest.h>

#include <algorithm>

#include "lab/tiles/tile_rival.h"
#include "oracle/scene_truth.h"
#include "server/view/tour.h"
#include "tests/support/scene.h"
#include "tests/support/seed.h"

namespace foreland::lab {
namespace {

std::shared_ptr<const terrain::Scene> smallScene() {
  static const auto scene = std::shared_ptr<const terrain::Scene>(test::makeScene(300, 220, 7));
  return scene;
}

const proto::Lens kLens{1.0471975511965976, 320, 180};

proto::Path tour(const char* name, double seconds) { return server::planTour(*smallScene(), name, seconds).value(); }

std::vector<TileId> level(const TileTree& tree, uint32_t wanted) {
  std::vector<TileId> tiles{{}};
  for (uint32_t l = 0; l < wanted; ++l) {
    std::vector<TileId> next;
    for (const TileId& tile : tiles)
      for (const TileId& child : tree.children(tile)) next.push_back(child);
    tiles = next;
  }
  return tiles;
}

TEST(TileTree, CoversTheDataOnEveryLevelAndEndsInTheTruth) {
  const TileTree tree(smallScene());
  oracle::Oracle oracle(oracle::truthOf(smallScene()));
  const proto::Path path = tour("survey", 20);
  ASSERT_EQ(tree.finestLevel(), 3u);
  for (uint32_t l = 0; l <= tree.finestLevel(); ++l) {
    const Time t = path.start + Duration::seconds(4.0 * l);
    const client::KeyframeMesh mesh = tree.drawn(level(tree, l), path.at(t).eye);
    const std::array<oracle::DrawnShare, 1> drawn{oracle::DrawnShare{&mesh, 1, 1}};
    const oracle::Deviation d = oracle.error(drawn, path.at(t), kLens);
    EXPECT_GT(d.samples, 100u);
    EXPECT_EQ(d.uncovered, 0u) << l;
    EXPECT_TRUE(l < tree.finestLevel() || d.max_m < 1e-3) << d.max_m;
  }
}

TEST(TileTree, KnowsTheHeightsThatItsMeshesHave) {
  const TileTree tree(smallScene());
  Rng rng(test::randomSeed());
  for (int i = 0; i < 300; ++i) {
    const auto tiles = level(tree, static_cast<uint32_t>(rng.below(4)));
    const TileId tile = tiles[rng.below(tiles.size())];
    const PeerMesh mesh = tree.mesh(tile);
    const glm::dvec3 p = mesh.positions[rng.below(mesh.positions.size())];
    const uint32_t side = TileTree::kCells << (tree.finestLevel() - tile.level);
    const auto x = tile.x * side + static_cast<uint32_t>(p.x), y = tile.y * side + static_cast<uint32_t>(p.y);
    EXPECT_NEAR(tree.heightAt(tile, x, y), p.z, 1e-9);
  }
}

// Whatever takes a tile's place moves what is drawn by as much as the oracle sees.
TEST(TileTree, MeasuresJumpsAsTheOracleDoes) {
  const TileTree tree(smallScene());
  oracle::Oracle oracle(oracle::truthOf(smallScene()));
  const proto::Path path = tour("survey", 20);
  const uint32_t finest = tree.finestLevel();
  for (double s = 0; s < 20; s += 3) {
    const proto::Pose pose = path.at(path.start + Duration::seconds(s));
    const client::KeyframeMesh fine = tree.drawn(level(tree, finest), pose.eye),
                               coarse = tree.drawn(level(tree, finest - 1), pose.eye);
    const std::array<oracle::DrawnShare, 1> a{oracle::DrawnShare{&fine, 1, 1}}, b{oracle::DrawnShare{&coarse, 1, 1}};
    double most = 0;
    for (const TileId& tile : level(tree, finest)) most = std::max(most, tree.jump(tile, tile.parent(), pose, kLens));
    // Samples whose other position leaves the screen count for the oracle alone.
    const double seen = oracle.difference(a, b, pose, kLens).max_px;
    EXPECT_LE(most, seen + 0.01);
    EXPECT_GE(most, 0.5 * seen);
  }
}

TileClient::Frame framesUntil(TileClient& client, const proto::Path& path, Time& now, Duration time) {
  TileClient::Frame last;
  for (const Time end = now + time; now < end; now = now + Duration::milliseconds(16))
    last = client.frame(now, path.at(now)).value();
  return last;
}

TEST(TileClient, LoadsWhatIsInViewOnceAndThenRests) {
  TileTree tree(smallScene());
  proto::Path path = tour("survey", 20);
  path.start = Time::seconds(60);  // it stands
  TileClient client(tree, {.lens = kLens, .links = sim::fixedLink(Duration::milliseconds(50))});
  Time now;
  EXPECT_FALSE(client.frame(now, path.at(now))->is_complete);
  const TileClient::Frame settled = framesUntil(client, path, now, Duration::milliseconds(3000));
  EXPECT_TRUE(settled.is_complete);
  EXPECT_GT(settled.drawn.size(), 1u);
  const uint64_t requests = client.statistics().requests;
  const TileClient::Frame later = framesUntil(client, path, now, Duration::milliseconds(1000));
  EXPECT_EQ(later.drawn, settled.drawn);
  EXPECT_EQ(later.jump_px, 0);
  EXPECT_EQ(client.statistics().requests, requests);
  EXPECT_EQ(client.statistics().bytes, client.statistics().bytes_once);
  for (const TileId& tile : settled.drawn)
    EXPECT_TRUE(tile.level == tree.finestLevel() || tree.screenError(tile, path.at(now), kLens) <= 2);
}

TEST(TileClient, NeverDrawsATileInAnother) {
  TileTree tree(smallScene());
  const proto::Path path = tour("spin", 6);
  TileClient client(tree, {.lens = kLens, .max_error_px = 0.7, .links = sim::linkNamed("lte")->links()});
  double jump_px = 0;
  for (Time now; now < Time::seconds(6); now = now + Duration::milliseconds(33)) {
    const TileClient::Frame frame = client.frame(now, path.at(now)).value();
    jump_px = std::max(jump_px, frame.jump_px);
    for (const TileId& a : frame.drawn)
      for (const TileId& b : frame.drawn) ASSERT_TRUE(a == b || !a.isIn(b));
  }
  EXPECT_GT(jump_px, 0);
}

TEST(TileClient, AsksAgainForWhatASmallCacheLost) {
  const auto flown = [](size_t cache_tiles) {
    TileTree tree(smallScene());
    const proto::Path path = tour("spin", 10);
    TileClient client(tree, {.lens = kLens,
                             .max_error_px = 0.7,
                             .cache_tiles = cache_tiles,
                             .links = sim::fixedLink(Duration::milliseconds(20))});
    Time now;
    framesUntil(client, path, now, Duration::milliseconds(10'000));
    return client.statistics();
  };
  const TileStatistics small = flown(1), large = flown(1000);
  EXPECT_EQ(large.bytes, large.bytes_once);
  EXPECT_GT(small.bytes, small.bytes_once);
}

TEST(TileRival, FindsTilesOfEqualErrorAndIsTheSameInEveryRun) {
  const auto world = std::make_shared<server::World>(smallScene());
  RivalFlight flight{.world = world, .path = tour("survey", 8), .seconds = 4, .lens = kLens};
  flight.path.start = Time{} + kTilesStanding;
  flight.links = sim::linkNamed("wifi")->links();
  oracle::Oracle oracle(oracle::truthOf(smallScene()));
  TileTree tree(smallScene());
  const RivalFigures ours = flyOurs(flight, oracle);
  EXPECT_GT(ours.bytes, 100u);
  EXPECT_LE(ours.max_px, 1);
  EXPECT_EQ(ours.bytes, flyOurs(flight, oracle).bytes);
  const auto equal_px = errorForRms(flight, ours.rms_px, tree, oracle);
  ASSERT_TRUE(equal_px.ok());
  TileOptions options{.lens = kLens, .max_error_px = *equal_px, .links = flight.links};
  const auto tiles = flyTiles(flight, options, tree, oracle);
  ASSERT_TRUE(tiles.ok());
  EXPECT_EQ(tiles->bytes, flyTiles(flight, options, tree, oracle)->bytes);
  options.max_error_px *= 4;
  EXPECT_GE(flyTiles(flight, options, tree, oracle)->rms_px, tiles->rms_px);
}

}  // namespace
}  // namespace foreland::lab
