// Laws of residency on random flights: what is drawn is parent-closed, within its bound, and goes on from mesh to mesh;
// and the page table says it. The reference looks through the list of tiles that are drawn.
#include "client/imagery/residency.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <random>
#include <set>

#include "tests/support/seed.h"

namespace foreland::test {
namespace {

using client::Residency;
using proto::TileId;
using Fade = Residency::Fade;

constexpr double kMetres = 10;  // a sample interval

proto::TileLayer layerOf(uint32_t width, uint32_t height) {
  proto::TileLayer layer;
  layer.width = width;
  layer.height = height;
  layer.texel = 0.5;
  layer.origin = {-0.25, -0.25};
  layer.step_m = 0.5;
  return layer;
}

proto::FrameTransform frame() {
  proto::Frame f;
  f.axis_x_m = {kMetres, 0};
  f.axis_y_m = {0, kMetres};
  return proto::FrameTransform(f);
}

proto::View lookingDown(const glm::dvec3& eye, double radius_m) {
  proto::View view;
  view.pose.eye = eye;
  view.lens = {.vertical_fov_rad = 1, .width_px = 1280, .height_px = 720};
  view.region_radius_m = radius_m;
  return view;
}

// The level that is shown at a texel position of level 0 where `wanted` is: a whole number where one image is shown
// alone, between two where they are mixed. Nothing where no tile is.
using Level = std::optional<double>;

double clampedBy(Fade fade, double weight) {
  return fade == Fade::kComing ? 1 - weight : fade == Fade::kGoing ? weight : 0;
}

Level levelByList(const std::vector<Residency::Shown>& shown, glm::dvec2 at, double wanted, double weight) {
  const Residency::Shown* finest = nullptr;
  for (const auto& s : shown) {
    const double side = proto::kTilePayload * static_cast<double>(1u << s.tile.level);
    const bool is_there = std::floor(at.x / side) == s.tile.x && std::floor(at.y / side) == s.tile.y;
    if (is_there && s.tile.level >= std::floor(wanted) && (finest == nullptr || s.tile.level < finest->tile.level))
      finest = &s;
  }
  if (finest == nullptr) return std::nullopt;
  return finest->tile.level + std::max({wanted - finest->tile.level, 0.0, clampedBy(finest->fade, weight)});
}

// As a shader reads it.
Level levelByTable(const Residency& residency, uint32_t levels, glm::dvec2 at, double wanted, double weight) {
  for (auto level = static_cast<uint32_t>(wanted); level < levels; ++level) {
    const double side = proto::kTilePayload * static_cast<double>(1u << level);
    const auto x = static_cast<uint32_t>(at.x / side), y = static_cast<uint32_t>(at.y / side);
    constexpr uint32_t kSide = Residency::kPageSide;
    const uint16_t* e = &residency.pageTable()[((level * kSide + y % kSide) * kSide + x % kSide) * 4];
    if (e[2] == 0 || e[0] != x / kSide || e[1] != y / kSide) continue;
    return level + std::max({wanted - level, 0.0, clampedBy(static_cast<Fade>(e[3]), weight)});
  }
  return std::nullopt;
}

// A flight over a layer whose tiles become known and decoded by chance.
class Flight {
 public:
  Flight(uint64_t seed, uint32_t texture_layers)
      : random_(seed),
        layer_(layerOf(500 + below(20'000), 500 + below(20'000))),
        texture_layers_(texture_layers),
        residency_(layer_, 0, texture_layers) {
    for (glm::dvec2& p : points_) p = {unit() * layer_.width, unit() * layer_.height};
  }

  void fly(int meshes) {
    glm::dvec3 eye{unit() * layer_.width * 5, unit() * layer_.height * 5, 100 + 4000 * unit()};
    for (int i = 0; i < meshes; ++i) {
      if (below(20) == 0) eye = {unit() * layer_.width * 5, unit() * layer_.height * 5, 20 + 9000 * unit()};
      const glm::dvec3 way = glm::dvec3(unit() - 0.5, unit() - 0.5, 0.2 * (unit() - 0.5)) * 600.0;
      eye += way;
      eye.z = std::max(eye.z, 5.0);
      step(lookingDown(eye, 50 * unit()), lookingDown(eye + way, 0));
      if (::testing::Test::HasFailure()) return;
    }
  }
  size_t arrivals() const { return arrivals_; }
  size_t revived() const { return revived_; }
  size_t measured() const { return measured_; }

 private:
  uint32_t below(uint32_t end) { return static_cast<uint32_t>(random_() % end); }
  double unit() { return static_cast<double>(random_() % 100'000) / 100'000; }

  void step(const proto::View& view, const proto::View& next) {
    std::vector<Level> before = levels(1);
    const auto held = [&](const TileId& tile) -> std::optional<proto::TileBounds> {
      if (tile.level + 1u < layer_.levels() && std::hash<uint64_t>{}(tile.key() * 0x9E3779B97F4A7C15u) % 10 == 0)
        return std::nullopt;
      return proto::TileBounds{0, 30, {0, 0, 127}, 20};
    };
    residency_.advance(frame(), view, next, held);
    expectClosedAndBounded();
    expectTexelsAreMeasured(view, held);
    expectLayersAreKept();
    expectTableAgrees();
    const std::vector<Level> after = levels(0);
    for (size_t i = 0; i < before.size(); ++i) {
      if (!before[i]) continue;
      ASSERT_TRUE(after[i]);
      ASSERT_NEAR(*before[i], *after[i], 1e-9) << "point " << i % points_.size();
    }
    for (uint32_t n = below(20); n > 0; --n)
      if (const auto tile = residency_.takeWanted()) {
        ready_.insert(tile->key());
        residency_.setReady(*tile);
      }
  }

  // Of what the view sees, at both ends of the mesh.
  void expectTexelsAreMeasured(const proto::View& view, const proto::TileLookup& held) {
    std::vector<proto::SelectedTile> seen;
    selectTiles(layer_, 0, frame(), view, 0.5, 100'000, held, seen);
    double largest_px = 0;
    for (const proto::SelectedTile& s : seen) {
      const double side = proto::kTilePayload * static_cast<double>(1u << s.tile.level);
      for (const double weight : {0.0, 1.0}) {
        const Level level =
            levelByList(residency_.shown(), side * glm::dvec2(s.tile.x + 0.5, s.tile.y + 0.5), s.tile.level, weight);
        if (!level || *level >= layer_.levels())
          largest_px = std::numeric_limits<double>::infinity();
        else if (*level > s.tile.level)
          largest_px = std::max(largest_px, s.texel_px * std::exp2(*level - s.tile.level));
      }
    }
    EXPECT_EQ(residency_.texelPx(), static_cast<float>(largest_px));
    measured_ += largest_px > 0 && std::isfinite(largest_px) ? 1 : 0;
  }

  std::vector<Level> levels(double weight) {
    std::vector<Level> out;
    for (const double wanted : {0.0, 0.4, 1.0, 1.7, 2.2, 3.9})
      for (const glm::dvec2& p : points_) out.push_back(levelByTable(residency_, layer_.levels(), p, wanted, weight));
    return out;
  }

  void expectClosedAndBounded() {
    std::set<uint64_t> drawn;
    std::set<uint32_t> layers;
    for (const auto& s : residency_.shown()) {
      drawn.insert(s.tile.key());
      EXPECT_LT(s.texture_layer, texture_layers_);
      EXPECT_TRUE(layers.insert(s.texture_layer).second) << "two tiles in one layer";
      EXPECT_TRUE(ready_.contains(s.tile.key())) << "a tile that was not decoded";
    }
    for (const auto& s : residency_.shown()) {
      if (s.tile.level + 1u == layer_.levels()) continue;
      EXPECT_TRUE(drawn.contains(s.tile.parent().key()));
    }
  }

  // What arrives is written while the mesh before is drawn, so into layers that neither draws; and what is drawn is
  // what was written last, with the parent's image in its layer.
  void expectLayersAreKept() {
    for (const auto& a : residency_.arrivals()) {
      for (const auto& s : last_shown_) ASSERT_NE(a.texture_layer, s.texture_layer);
      ASSERT_EQ(a.parent_layer.has_value(), a.tile.level + 1u < layer_.levels());
      if (a.parent_layer) { ASSERT_EQ(written_[*a.parent_layer], a.tile.parent().key()); }
      written_[a.texture_layer] = a.tile.key();
      ++arrivals_;
    }
    size_t coming = 0;
    for (const auto& s : residency_.shown()) {
      ASSERT_EQ(written_[s.texture_layer], s.tile.key());
      coming += s.fade == Fade::kComing ? 1 : 0;
    }
    revived_ += coming - residency_.arrivals().size();
    for (const TileId& tile : residency_.dropped()) ready_.erase(tile.key());
    last_shown_ = residency_.shown();
  }

  void expectTableAgrees() {
    for (const double wanted : {0.0, 1.0, 2.5})
      for (const glm::dvec2& p : points_)
        for (const double weight : {0.0, 0.3, 1.0})
          ASSERT_EQ(levelByTable(residency_, layer_.levels(), p, wanted, weight),
                    levelByList(residency_.shown(), p, wanted, weight));
  }

  std::mt19937_64 random_;
  proto::TileLayer layer_;
  uint32_t texture_layers_;
  Residency residency_;
  std::array<glm::dvec2, 60> points_;
  std::set<uint64_t> ready_;
  std::map<uint32_t, uint64_t> written_;
  std::vector<Residency::Shown> last_shown_;
  size_t arrivals_ = 0, revived_ = 0, measured_ = 0;
};

TEST(Residency, EveryMeshBeginsAsTheLastOneEnded) {
  const uint64_t seed = randomSeed();
  size_t arrivals = 0, revived = 0, measured = 0;
  for (uint64_t i = 0; i < 12; ++i) {
    Flight flight(seed + i, i % 3 == 0 ? 8 : i % 3 == 1 ? 24 : 64);
    flight.fly(150);
    if (HasFailure()) return;
    arrivals += flight.arrivals(), revived += flight.revived(), measured += flight.measured();
  }
  EXPECT_GT(arrivals, 500u);
  EXPECT_GT(revived, 0u);
  EXPECT_GT(measured, 100u);
}

// Where the camera stands everything that is selected comes, a level with each mesh.
TEST(Residency, AStandingViewGetsWhatItSelects) {
  const proto::TileLayer layer = layerOf(4000, 4000);
  Residency residency(layer, 0, 64);
  const proto::View view = lookingDown({10'000, 10'000, 4000}, 0);
  const auto held = [](const TileId&) { return std::optional(proto::TileBounds{0, 10, {0, 0, 127}, 20}); };
  std::vector<proto::SelectedTile> selected;
  selectTiles(layer, 0, frame(), view, 0.5, 56, held, selected);
  ASSERT_GT(selected.size(), 20u);
  for (int i = 0; i < 20; ++i) {
    residency.advance(frame(), view, view, held);
    while (const auto tile = residency.takeWanted()) residency.setReady(*tile);
  }
  EXPECT_EQ(residency.shown().size(), selected.size());
  for (const auto& s : residency.shown()) EXPECT_EQ(s.fade, Fade::kNone);
  EXPECT_TRUE(residency.arrivals().empty());
}

TEST(Residency, LeavesOutWhatIsSmallestOnTheScreen) {
  const proto::TileLayer layer = layerOf(6000, 6000);
  Residency residency(layer, 0, 40);
  proto::View view = lookingDown({15'000, 2000, 900}, 0);
  view.pose.orientation = glm::dquat(std::cos(0.65), std::sin(0.65), 0, 0);  // ahead, and somewhat down
  const auto held = [](const TileId&) { return std::optional(proto::TileBounds{0, 10, {0, 0, 127}, 20}); };
  for (int i = 0; i < 40; ++i) {
    residency.advance(frame(), view, view, held);
    while (const auto tile = residency.takeWanted()) residency.setReady(*tile);
  }
  std::vector<proto::SelectedTile> all;
  selectTiles(layer, 0, frame(), view, 0.5, 100'000, held, all);
  std::set<uint64_t> drawn;
  for (const auto& s : residency.shown()) drawn.insert(s.tile.key());
  ASSERT_EQ(drawn.size(), 35u);
  ASSERT_GT(all.size(), 70u);
  float smallest_px = 1e9;
  for (size_t i = 1; i < all.size(); ++i)
    if (drawn.contains(all[i].tile.key())) smallest_px = std::min(smallest_px, all[i].texel_px);
  for (const auto& s : all)
    if (!drawn.contains(s.tile.key())) { EXPECT_LE(s.texel_px, smallest_px) << int{s.tile.level}; }
}

// What is expected to be seen is decoded with one mesh and fades in with the next, before it is.
TEST(Residency, WhatIsExpectedIsThereBeforeItIsSeen) {
  const proto::TileLayer layer = layerOf(60'000, 3000);
  const auto held = [](const TileId&) { return std::optional(proto::TileBounds{0, 10, {0, 0, 127}, 20}); };
  const auto viewAt = [](int i) { return lookingDown({5000 + 40.0 * i, 7000, 700}, 0); };
  std::array<size_t, 2> coarse{};
  for (const int ahead : {0, 2}) {
    Residency residency(layer, 0, 256);
    for (int i = 0; i < 400; ++i) {
      residency.advance(frame(), viewAt(i), viewAt(i + ahead), held);
      while (const auto tile = residency.takeWanted()) residency.setReady(*tile);
      if (i > 20 && residency.texelPx() > 0) ++coarse[ahead > 0];
    }
  }
  EXPECT_GT(coarse[0], 10u);
  EXPECT_EQ(coarse[1], 0u);
}

// One hundred views later than all of it was seen, nothing is left in the way of what is.
TEST(Residency, WhatIsNotSelectedMakesRoom) {
  const proto::TileLayer layer = layerOf(60'000, 3000);
  Residency residency(layer, 0, 24);
  const auto held = [](const TileId&) { return std::optional(proto::TileBounds{0, 10, {0, 0, 127}, 20}); };
  std::vector<proto::SelectedTile> selected;
  proto::View view;
  for (int i = 0; i < 140; ++i) {
    view = lookingDown({std::min(i, 100) * 2500.0, 7000, 700}, 0);
    residency.advance(frame(), view, view, held);
    while (const auto tile = residency.takeWanted()) residency.setReady(*tile);
  }
  selectTiles(layer, 0, frame(), view, 1, 21, held, selected);
  std::set<uint64_t> drawn;
  for (const auto& s : residency.shown()) drawn.insert(s.tile.key());
  for (const auto& s : selected) EXPECT_TRUE(drawn.contains(s.tile.key())) << int{s.tile.level};
}

}  // namespace
}  // namespace foreland::test
