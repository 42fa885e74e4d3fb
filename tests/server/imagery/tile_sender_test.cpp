// Which tiles of imagery a viewer is sent beyond what it must have, and in which order.
#include "server/imagery/tile_sender.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>
#include <utility>
#include <vector>

#include "server/view/ground.h"
#include "terrain/pipeline/build.h"
#include "tests/support/formula_picture.h"
#include "tests/support/scene.h"

namespace foreland::server {
namespace {

// Of 1/16 of a sample interval a texel, with detail at every size.
std::shared_ptr<const terrain::Scene> pictured() {
  test::FormulaPicture picture(161, 150, 1.0 / 16, [](double x, double y) {
    double light = 128;
    for (double wave = 20; wave > 0.1; wave /= 1.7) light += 14 * std::sin(x / wave + wave) * std::cos(y / wave);
    const auto grey = static_cast<uint8_t>(std::clamp(light, 0.0, 255.0));
    return terrain::Rgba{grey, grey, grey, 255};
  });
  test::FormulaSource source(161, 150, test::hills(4));
  const test::TemporaryFolder folder;
  EXPECT_TRUE(terrain::buildScene(source, {.output = folder / "scene.fls", .additions = {.picture = &picture}}).ok());
  return *terrain::Scene::open(folder / "scene.fls");
}

class TileSenderTest : public testing::Test {
 protected:
  TileSenderTest() : hierarchy(pictured()) {
    ground = std::make_shared<const SceneGround>(SceneGround{GroundSquares(hierarchy), HorizonGrid::of(hierarchy)});
    request.imagery = true;
    view.lens = {1.0471975511965976, 1280, 720};
    const glm::dvec3 eye = hierarchy.frame().transform().toScene(proto::LatticePosition{70, 20, 0});
    const double ground_m = groundHeight(hierarchy.scene(), 70, 20).value();
    view.pose = {eye + glm::dvec3(0, 0, ground_m + kHeight_m), proto::lookAlong({0.1, 0.9, -0.4}, {0, 0, 1})};
  }

  // What is held after a while of this view, on a link that is never full.
  std::set<uint64_t> sentFor(std::span<const TileSender::Dwell> stays) {
    TileSender sender(hierarchy, ground, 64 << 20);
    const std::array targets{TileSender::Target{view, {view.pose.eye}}, TileSender::Target{view, {view.pose.eye}}};
    for (uint32_t k = 1; k <= 100; ++k) {
      const Time now = Time::seconds(0.2 * k);
      sender.choose(k, targets, stays, request);
      sender.pace().keyframeSent(k, 3000, now, 0.2, 0);
      std::vector<Bytes> messages;
      sender.takeTiles(messages);
      sender.pace().keyframeArrived(k, now + Duration::milliseconds(20), Duration::milliseconds(40));
    }
    std::set<uint64_t> keys;
    sender.held().visit([&](const proto::TileId& tile, uint32_t) { keys.insert(tile.key()); });
    return keys;
  }

  static constexpr double kHeight_m = 1200;

  Hierarchy hierarchy;
  std::shared_ptr<const SceneGround> ground;
  proto::ViewRequest request;
  proto::View view;
};

TEST_F(TileSenderTest, MoreIsSentOfWhatIsSeenForLonger) {
  std::set<uint64_t> before;
  std::vector<size_t> counts;
  for (const double seconds : {0.0, 1.0, 10.0, 1000.0}) {
    const std::array stays{TileSender::Dwell{view.pose, seconds}};
    const std::set<uint64_t> sent = sentFor(stays);
    EXPECT_TRUE(std::includes(sent.begin(), sent.end(), before.begin(), before.end())) << seconds;
    counts.push_back(sent.size());
    before = sent;
  }
  EXPECT_GT(counts.front(), 8u) << "what it must have";
  EXPECT_GT(counts.back(), counts[2]);
  EXPECT_GT(counts[2], counts.front());
}

TEST_F(TileSenderTest, NothingFinerIsSentOfWhatIsLeftBehind) {
  proto::Pose back = view.pose;
  back.orientation = proto::lookAlong({-0.1, -0.9, -0.2}, {0, 0, 1});
  const std::array away{TileSender::Dwell{back, 1000}}, never{TileSender::Dwell{view.pose, 0}};
  EXPECT_EQ(sentFor(away), sentFor(never));
}

// From further back all is in view that was, and smaller.
TEST_F(TileSenderTest, LessIsSentOfWhatTheCameraWillBeFurtherFrom) {
  proto::Pose back = view.pose;
  back.eye -= 1.5 * kHeight_m * glm::dvec3(0.1, 0.9, -0.4);
  const std::array here{TileSender::Dwell{view.pose, 10}}, there{TileSender::Dwell{back, 10}};
  const std::set<uint64_t> sent = sentFor(here), sent_there = sentFor(there);
  EXPECT_TRUE(std::includes(sent.begin(), sent.end(), sent_there.begin(), sent_there.end()));
  EXPECT_LT(sent_there.size(), sent.size());
}

// Of all that is needed now and later, while the link is too slow for it; and tiles come after their parents.
TEST_F(TileSenderTest, WhatIsLargestOnTheScreenComesFirst) {
  TileSender sender(hierarchy, nullptr, 64 << 20);  // sizes are by tiles' own bounds
  proto::View above = view, later = view;
  above.pose = {view.pose.eye + glm::dvec3(0, 0, 100 * kHeight_m), glm::dquat(1, 0, 0, 0)};
  later.pose.eye += 0.6 * kHeight_m * glm::dvec3(0.1, 0.9, -0.6);
  const terrain::TileTable& table = hierarchy.scene().tiles();
  std::map<uint64_t, float> sizes_px, of_now;
  for (const proto::View* each : {&view, &later}) {
    std::vector<proto::SelectedTile> needed;
    proto::selectTiles(
        table.layers()[1], 1, hierarchy.frame().transform(), *each, TileSender::kTexel_px, TileSender::kMaxSelected,
        [&](const proto::TileId& tile) { return table.bounds(tile); }, needed);
    for (const proto::SelectedTile& tile : needed) {
      const auto parent = sizes_px.find(tile.tile.parent().key());
      sizes_px.emplace(tile.tile.key(),
                       parent == sizes_px.end() ? tile.texel_px : std::min(tile.texel_px, parent->second));
    }
    if (each == &view) of_now = sizes_px;
  }
  std::vector<proto::TileId> sent;
  const auto send = [&](uint32_t keyframe, const proto::View& first, const proto::View& second) {
    const std::array targets{TileSender::Target{first, {first.pose.eye}},
                             TileSender::Target{second, {second.pose.eye}}};
    const Time now = Time::seconds(0.2 * keyframe);
    sender.choose(keyframe, targets, {}, request);
    sender.pace().keyframeSent(keyframe, 300, now, 0.05, 0);
    std::vector<Bytes> messages;
    sender.takeTiles(messages);
    for (const Bytes& message : messages) sent.push_back(proto::decodeTile(message).value().tile);
    sender.pace().keyframeArrived(keyframe, now + Duration::milliseconds(20), Duration::milliseconds(40));
  };
  // From high above little is needed. Nothing is sent for later before the first view is whole.
  uint32_t keyframe = 1;
  for (; keyframe <= 20; ++keyframe) send(keyframe, above, above);
  std::set<uint64_t> held;
  for (const proto::TileId& tile : std::exchange(sent, {})) held.insert(tile.key());
  EXPECT_LT(held.size(), 6u);
  for (; keyframe <= 200; ++keyframe) send(keyframe, view, later);
  ASSERT_GT(sent.size(), 20u);
  size_t ahead = 0, behind = 0;  // of need
  for (size_t i = 0; i < sent.size(); ++i) {
    ASSERT_TRUE(sizes_px.contains(sent[i].key()));
    if (i > 0) { EXPECT_LE(sizes_px[sent[i].key()], sizes_px[sent[i - 1].key()]) << i; }
    EXPECT_TRUE(table.layers()[1].isCoarsest(sent[i]) || held.contains(sent[i].parent().key())) << i;
    EXPECT_TRUE(held.insert(sent[i].key()).second);
    if (!of_now.contains(sent[i].key()))
      ++ahead;
    else if (ahead > 0)
      ++behind;
  }
  EXPECT_GT(behind, 0u) << "some of what is needed now is less urgent";
  for (const auto& [key, size_px] : sizes_px) EXPECT_TRUE(held.contains(key));
}

}  // namespace
}  // namespace foreland::server
