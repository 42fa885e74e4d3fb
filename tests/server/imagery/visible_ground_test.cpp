// What bounds the ground, and what a viewer needs of it, against the finest triangles of a scene: lines of sight are
// marched along, and texels projected, by code that knows neither bounds nor horizons.
#include "server/imagery/visible_ground.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <unordered_set>

#include "base/rng.h"
#include "tests/support/height_field.h"
#include "tests/support/scene.h"
#include "tests/support/seed.h"
#include "tests/support/texel_on_screen.h"

namespace foreland::server {
namespace {

constexpr uint32_t kColumns = 403, kRows = 330;

double ridges(uint32_t x, uint32_t y) {
  return 900 + 260 * std::sin(x / 21.0) * std::cos(y / 29.0) + 25 * std::sin(x / 3.1 + y / 2.3);
}

class VisibleGroundTest : public testing::TestWithParam<proto::FrameKind> {
 protected:
  VisibleGroundTest() : hierarchy(test::makeScene(kColumns, kRows, ridges, GetParam())), field(hierarchy) {
    ground = std::make_shared<const SceneGround>(SceneGround{GroundSquares(hierarchy), HorizonGrid::of(hierarchy)});
    // Finer than samples, as imagery is.
    layer.content = proto::TileContent::kImagery;
    layer.coding = proto::TileCoding::kWebP;
    layer.width = 32 * kColumns, layer.height = 32 * kRows;
    layer.texel = 1.0 / 32;
    layer.origin = {-0.5, -0.5};
  }

  const proto::FrameTransform& frame() const { return hierarchy.frame().transform(); }
  glm::dvec3 at(double x, double y) const { return frame().toScene(proto::LatticePosition{x, y, field.at(x, y)}); }
  // How much larger a texel may look on the slope at a point than on one of 60 degrees, as which a steeper one counts.
  double steepness(double x, double y) const {
    const double d = 0.01;
    const glm::dvec3 n = glm::normalize(glm::cross(at(x + d, y) - at(x, y), at(x, y + d) - at(x, y)));
    const glm::dvec3 up = glm::normalize(frame().toScene(proto::LatticePosition{x, y, field.at(x, y) + 1}) - at(x, y));
    return std::sqrt(std::max(1.0, 0.5 / glm::dot(n, up)));
  }

  proto::View someView(Rng& rng) const {
    proto::View view;
    const double x = rng.uniform(0, kColumns - 1), y = rng.uniform(0, kRows - 1);
    view.pose.eye = frame().toScene(proto::LatticePosition{x, y, field.at(x, y) + rng.uniform(15, 400)});
    const auto turn = [](double angle, glm::dvec3 axis) {
      return glm::dquat(std::cos(angle / 2), std::sin(angle / 2) * axis);
    };
    view.pose.orientation =
        turn(rng.uniform(-3.14, 3.14), {0, 0, 1}) * turn(rng.uniform(1.1, 1.6), {1, 0, 0}) * turn(0.1, {0, 0, 1});
    view.lens = {rng.uniform(0.5, 1.2), 1280, 720};
    view.tau_px = 1;
    return view;
  }
  // By nothing better than the scene's range of heights.
  proto::TileBounds loosest() const {
    const auto range = hierarchy.scene().heightRange();
    const double quantum_m = frame().frame().height_quantum_m;
    return {
        static_cast<float>(range.lowest * quantum_m), static_cast<float>(range.highest * quantum_m), {0, 0, 0}, 255};
  }
  std::vector<proto::SelectedTile> select(const proto::View& view, proto::TileGround* with) const {
    std::vector<proto::SelectedTile> selected;
    proto::selectTiles(
        layer, 0, frame(), view, 2, 100000, [&](const proto::TileId&) { return loosest(); }, selected, with);
    return selected;
  }

  Hierarchy hierarchy;
  test::HeightField field;
  std::shared_ptr<const SceneGround> ground;
  proto::TileLayer layer;
  proto::TileMemory held;
};

TEST_P(VisibleGroundTest, NoTexelThatIsSeenIsLargerThanAllowed) {
  Rng rng(test::randomSeed());
  size_t judged = 0, with_ground = 0, without = 0;
  for (int i = 0; i < 10; ++i) {
    proto::View view = someView(rng);
    view.region_radius_m = i % 2 ? static_cast<float>(rng.uniform(1, 20)) : 0;
    VisibleGround visible(std::span(&layer, 1), ground, held);
    visible.look({view.pose.eye, glm::dvec3(0), view.region_radius_m + 0.01}, view);
    std::unordered_set<uint64_t> tiles;
    for (const proto::SelectedTile& s : select(view, &visible)) tiles.insert(s.tile.key());
    with_ground += tiles.size();
    without += select(view, nullptr).size();
    proto::View seen = view;  // from anywhere in the region
    const glm::dvec3 away(rng.uniform(-1, 1), rng.uniform(-1, 1), rng.uniform(-1, 1));
    seen.pose.eye += glm::normalize(away) * (0.99 * view.region_radius_m);
    const proto::LatticePosition eye = frame().toLattice(seen.pose.eye);
    for (int k = 0; k < 12000; ++k) {
      // The nearer the more.
      const double far = 300 * std::pow(rng.uniform(0, 1), 2), heading = rng.uniform(-3.15, 3.15);
      const double x = eye.x + far * std::cos(heading), y = eye.y + far * std::sin(heading);
      if (x < 0 || y < 0 || x > kColumns - 1.1 || y > kRows - 1.1 || !test::project(seen, at(x, y))) continue;
      uint8_t level = 0;
      const auto tileAt = [&](uint8_t l) {
        const glm::dvec2 p = (glm::dvec2(x, y) - layer.origin) / (proto::kTilePayload * layer.texelAt(l));
        return proto::TileId{0, l, static_cast<uint32_t>(p.x), static_cast<uint32_t>(p.y)};
      };
      while (level + 1u < layer.levels() && !tiles.contains(tileAt(level).key())) ++level;
      if (level == 0 || !field.isClear(seen.pose.eye, at(x, y), 1)) continue;
      const auto size =
          test::texelOnScreen([&](double u, double v) { return at(u, v); }, seen, x, y, layer.texelAt(level), 0.01);
      if (!size) continue;
      ++judged;
      EXPECT_LE(*size, 2 * 1.02 * steepness(x, y))
          << "level " << int(level) << " at " << x << ", " << y << " in view " << i;
    }
  }
  EXPECT_GT(judged, 300u);
  EXPECT_LT(with_ground, without * 3 / 4);
}

TEST_P(VisibleGroundTest, SquaresHoldTheGround) {
  Rng rng(test::randomSeed());
  const GroundSquares& squares = ground->squares;
  ASSERT_GT(squares.levels(), 3u);
  for (int k = 0; k < 3000; ++k) {
    const double x = rng.uniform(0, kColumns - 1.1), y = rng.uniform(0, kRows - 1.1);
    const double height_m = field.at(x, y), d = 1e-6;
    const double along_x = (field.at(x + d, y) - height_m) / d, along_y = (field.at(x, y + d) - height_m) / d;
    const std::array<double, 4> rise{along_x, along_y, along_x + along_y, along_x - along_y};
    for (uint32_t level = 0; level < squares.levels(); ++level) {
      const GroundSquares::Square& s = squares.square(level, static_cast<uint32_t>(x) / squares.side(level),
                                                      static_cast<uint32_t>(y) / squares.side(level));
      EXPECT_GE(height_m, s.lowest_m - 1e-3);
      EXPECT_LE(height_m, s.highest_m + 1e-3);
      // A point on an edge may see the triangle beside its own.
      if (std::floor(x + d) != std::floor(x) || std::floor(y + d) != std::floor(y)) continue;
      for (size_t i = 0; i < rise.size(); ++i) {
        EXPECT_GE(rise[i], s.min_rise_m[i] - 1e-2) << "level " << level;
        EXPECT_LE(rise[i], s.largest_rise_m[i] + 1e-2) << "level " << level;
      }
    }
  }
}

TEST_P(VisibleGroundTest, PartsAndTheirPartsCoverTheirTile) {
  Rng rng(test::randomSeed());
  VisibleGround visible(std::span(&layer, 1), ground, held);
  for (int k = 0; k < 300; ++k) {
    const auto level = static_cast<uint8_t>(rng.uniform(0, layer.levels()));
    const proto::TileId tile{0, level, static_cast<uint32_t>(rng.uniform(0, layer.tilesX(level))),
                             static_cast<uint32_t>(rng.uniform(0, layer.tilesY(level)))};
    const auto area = [](const proto::LatticeBox& box) { return (box.high.x - box.low.x) * (box.high.y - box.low.y); };
    std::vector<proto::TilePart> parts;
    ASSERT_TRUE(visible.parts(tile, parts));
    double sum = 0;
    for (const proto::TilePart& part : parts) {
      sum += area(part.box);
      std::vector<proto::TilePart> smaller;
      if (!visible.split(part, smaller)) continue;
      double of_smaller = 0;
      for (const proto::TilePart& each : smaller) of_smaller += area(each.box);
      EXPECT_NEAR(of_smaller, area(part.box), 1e-6);
    }
    EXPECT_NEAR(sum, area(layer.boxOf(tile)), 1e-6);
  }
}

INSTANTIATE_TEST_SUITE_P(Frames, VisibleGroundTest,
                         testing::Values(proto::FrameKind::kPlanar, proto::FrameKind::kGeographic),
                         [](const auto& frame) {
                           return frame.param == proto::FrameKind::kGeographic ? "geographic" : "planar";
                         });

}  // namespace
}  // namespace foreland::server
