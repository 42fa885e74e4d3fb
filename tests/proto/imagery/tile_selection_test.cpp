// Which tiles a view needs, against a camera that shares no code with the selection: the texel under a visible point of
// the ground is projected to the screen.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/gtc/constants.hpp>
#include <map>
#include <unordered_set>

#include "base/rng.h"
#include "proto/imagery/tile_selection.h"
#include "tests/support/seed.h"
#include "tests/support/texel_on_screen.h"

namespace foreland::proto {
namespace {

constexpr uint32_t kSamples = 3001;

// Hills over a lattice of 10 m, planar, or on the earth.
class Hills {
 public:
  explicit Hills(bool is_geographic) : frame_(frameOf(is_geographic)), transform_(frame_) {
    layer_.width = layer_.height = kSamples;
    layer_.origin = {-0.5, -0.5};
    layer_.step_m = 0.5;
  }

  const TileLayer& layer() const { return layer_; }
  const FrameTransform& transform() const { return transform_; }
  static double heightAt(double x, double y) {
    return 900 + 500 * std::sin(x / 170) * std::cos(y / 230) + 40 * std::sin(x / 13 + y / 17);
  }
  glm::dvec3 at(double x, double y) const { return transform_.toScene(LatticePosition{x, y, heightAt(x, y)}); }

  // Found by looking at points no farther apart than the hills' details, with room for what lies between.
  TileBounds boundsOf(const TileId& tile) {
    const auto found = bounds_.find(tile.key());
    if (found != bounds_.end()) return found->second;
    const LatticeBox box = layer_.boxOf(tile);
    double low = 1e9, high = -1e9;
    glm::dvec3 sum(0);
    std::vector<glm::dvec3> normals;
    const double step = std::max(2.0, (box.high.x - box.low.x) / 150);
    for (double x = box.low.x; x <= box.high.x; x += step)
      for (double y = box.low.y; y <= box.high.y; y += step) {
        low = std::min(low, heightAt(x, y)), high = std::max(high, heightAt(x, y));
        normals.push_back(glm::normalize(glm::cross(at(x + 1, y) - at(x - 1, y), at(x, y + 1) - at(x, y - 1))));
        sum += normals.back();
      }
    const glm::dvec3 axis = glm::normalize(sum);
    TileBounds bounds{static_cast<float>(low - 10), static_cast<float>(high + 10)};
    for (int i = 0; i < 3; ++i) bounds.axis[i] = static_cast<int8_t>(std::lround(127 * axis[i]));
    double widest = 0;
    for (const glm::dvec3& n : normals) widest = std::max(widest, std::acos(std::min(1.0, glm::dot(n, axis))));
    bounds.half_angle = static_cast<uint8_t>(std::min(255.0, std::ceil((widest + 0.05) * 510 / glm::pi<double>())));
    return bounds_[tile.key()] = bounds;
  }

 private:
  static Frame frameOf(bool is_geographic) {
    Frame frame;
    if (!is_geographic) {
      frame.axis_x_m = {10, 0}, frame.axis_y_m = {0, 10};
      return frame;
    }
    frame.kind = FrameKind::kGeographic;
    frame.latitude0_rad = 0.7, frame.longitude0_rad = 0.1;
    frame.latitude_step_rad = 10 / 6.4e6, frame.longitude_step_rad = 10 / 5.0e6;
    frame.origin = {0.7 + 1500 * frame.latitude_step_rad, 0.1 + 1500 * frame.longitude_step_rad, 0};
    return frame;
  }

  Frame frame_;
  FrameTransform transform_;
  TileLayer layer_;
  std::map<uint64_t, TileBounds> bounds_;
};

View someView(Rng& rng, const Hills& hills) {
  View view;
  const double x = rng.uniform(0, kSamples), y = rng.uniform(0, kSamples);
  view.pose.eye = hills.transform().toScene(LatticePosition{x, y, Hills::heightAt(x, y) + rng.uniform(20, 3000)});
  const double heading = rng.uniform(-3.14, 3.14), pitch = rng.uniform(0.2, 1.6), roll = rng.uniform(-0.3, 0.3);
  const auto turn = [](double angle, glm::dvec3 axis) {
    return glm::dquat(std::cos(angle / 2), std::sin(angle / 2) * axis);
  };
  view.pose.orientation = turn(heading, {0, 0, 1}) * turn(pitch, {1, 0, 0}) * turn(roll, {0, 0, 1});
  view.lens = {rng.uniform(0.5, 1.4), 1280, 720};
  return view;
}

class TileSelection : public testing::TestWithParam<bool> {};

TEST_P(TileSelection, NoTexelInViewIsLargerThanAllowed) {
  Hills hills(GetParam());
  Rng rng(test::randomSeed());
  size_t points = 0, fine = 0;
  for (int i = 0; i < 12; ++i) {
    View view = someView(rng, hills);
    view.region_radius_m = i % 2 ? rng.uniform(0, 50) : 0;
    view.region_angle_rad = i % 2 ? rng.uniform(0, 0.1) : 0;
    std::vector<SelectedTile> selected;
    selectTiles(
        hills.layer(), 0, hills.transform(), view, 2, 100000, [&](const TileId& t) { return hills.boundsOf(t); },
        selected);
    std::unordered_set<uint64_t> tiles;
    for (const SelectedTile& s : selected) tiles.insert(s.tile.key());
    View seen = view;  // from anywhere in the region
    glm::dvec3 away(rng.uniform(-1, 1), rng.uniform(-1, 1), rng.uniform(-1, 1));
    seen.pose.eye += glm::normalize(away) * (0.99 * view.region_radius_m);
    for (int k = 0; k < 3000; ++k) {
      const double x = rng.uniform(0, kSamples - 1), y = rng.uniform(0, kSamples - 1);
      if (!test::project(seen, hills.at(x, y))) continue;
      // The finest tile that holds the point.
      uint8_t level = static_cast<uint8_t>(hills.layer().levels());
      for (uint8_t l = 0; l < hills.layer().levels() && level == hills.layer().levels(); ++l) {
        const double side = kTilePayload * hills.layer().texelAt(l);
        const TileId tile{0, l, static_cast<uint32_t>((x + 0.5) / side), static_cast<uint32_t>((y + 0.5) / side)};
        if (tiles.contains(tile.key())) level = l;
      }
      ASSERT_LT(level, hills.layer().levels()) << "a point in view has no tile";
      const auto at = [&](double u, double v) { return hills.at(u, v); };
      const auto size = test::texelOnScreen(at, seen, x, y, hills.layer().texelAt(level));
      ++points;
      fine += level == 0;
      if (!size || level == 0) continue;
      EXPECT_LE(*size, 2 * 1.01) << "level " << int(level) << " at " << x << ", " << y;
    }
  }
  EXPECT_GT(points, 300u);
  EXPECT_GT(fine, 10u);
}

TEST_P(TileSelection, FollowsParentsAndLeavesOutWhatIsNotKnown) {
  Hills hills(GetParam());
  Rng rng(test::randomSeed());
  for (int i = 0; i < 20; ++i) {
    const View view = someView(rng, hills);
    std::vector<SelectedTile> all, some, few;
    const auto known = [&](const TileId& t) { return hills.boundsOf(t); };
    selectTiles(hills.layer(), 0, hills.transform(), view, 2, 100000, known, all);
    const auto lucky = [&](const TileId& t) -> std::optional<TileBounds> {
      if (t.key() * 0x9e3779b97f4a7c15 >> 62 == 0 && t.level + 1u < hills.layer().levels()) return std::nullopt;
      return hills.boundsOf(t);
    };
    selectTiles(hills.layer(), 0, hills.transform(), view, 2, 100000, lucky, some);
    selectTiles(hills.layer(), 0, hills.transform(), view, 2, all.size() / 2, known, few);
    ASSERT_LE(some.size(), all.size());
    EXPECT_EQ(few.size(), all.size() / 2);
    for (const auto* each : {&all, &some, &few}) {
      std::unordered_set<uint64_t> before;
      for (const SelectedTile& s : *each) {
        EXPECT_TRUE(hills.layer().has(s.tile));
        EXPECT_TRUE(s.tile.level + 1u == hills.layer().levels() || before.contains(s.tile.parent().key()));
        EXPECT_TRUE(before.insert(s.tile.key()).second);
      }
    }
    for (const SelectedTile& s : some) EXPECT_TRUE(lucky(s.tile).has_value());
  }
}

// As at the latitude where degrees of longitude are a quarter of those of latitude.
TEST(TileSelectionAbove, ATexelIsAsLargeAsTheRootOfItsArea) {
  Frame frame;
  frame.axis_x_m = {5, 0}, frame.axis_y_m = {0, 20};
  const FrameTransform transform(frame);
  TileLayer layer;
  layer.width = layer.height = kSamples;
  layer.origin = {-0.5, -0.5};
  View view;
  view.pose.eye = transform.toScene(LatticePosition{1600, 1600, 20000});
  view.lens = {1.0, 1280, 720};
  std::vector<SelectedTile> selected;
  selectTiles(
      layer, 0, transform, view, 0.3, 100000,
      [](const TileId&) {
        return TileBounds{0, 0, {0, 0, 127}, 0};
      },
      selected);
  const TileId below{0, 0, 1600 / kTilePayload, 1600 / kTilePayload};
  const auto found =
      std::find_if(selected.begin(), selected.end(), [&](const SelectedTile& each) { return each.tile == below; });
  ASSERT_NE(found, selected.end());
  const auto at = [&](double x, double y) { return transform.toScene(LatticePosition{x, y, 0}); };
  const double size_px = *test::texelOnScreen(at, view, 1600, 1600, layer.texel);
  EXPECT_GE(found->texel_px, 0.999 * size_px);
  EXPECT_LE(found->texel_px, 1.4 * size_px);
}

INSTANTIATE_TEST_SUITE_P(Frames, TileSelection, testing::Bool(),
                         [](const auto& frame) { return frame.param ? "geographic" : "planar"; });

}  // namespace
}  // namespace foreland::proto
