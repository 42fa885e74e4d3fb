// Tiles that a view of a globe needs: no texel of what is in view is larger on the screen than stated, on any face.
#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>
#include <glm/gtc/quaternion.hpp>
#include <unordered_set>

#include "base/rng.h"
#include "proto/imagery/tile_selection.h"
#include "tests/support/seed.h"

namespace foreland::proto {
namespace {

Frame earth(uint32_t face_log2) {
  Frame frame;
  frame.kind = FrameKind::kGlobe;
  frame.face_steps = 1u << face_log2;
  frame.origin.height_m = -500;
  return frame;
}

TileLayer layerOf(uint32_t face_steps, uint32_t width) {
  TileLayer layer;
  layer.content = TileContent::kImagery;
  layer.coding = TileCoding::kWebP;
  layer.width = layer.height = width;
  layer.face_steps = face_steps;
  layer.texel = static_cast<double>(face_steps) / width;
  return layer;
}

glm::dvec2 faceOrigin(const TileLayer& layer, uint32_t face) { return {1.0 * face * layer.face_steps, 0}; }

// Of ground at height 0: a cone about the normal in the tile's middle.
TileBounds boundsOf(const TileLayer& layer, const FrameTransform& frame, const TileId& tile) {
  const LatticeBox box = layer.boxOf(tile);
  const glm::dvec2 origin = faceOrigin(layer, layer.faceOf(tile));
  const auto normal = [&](double u, double v) {
    const glm::dvec2 at = (box.low + (box.high - box.low) * glm::dvec2(u, v) - origin) * (2.0 / layer.face_steps) - 1.0;
    return glm::normalize(cubeVector({layer.faceOf(tile), at.x, at.y}));
  };
  (void)frame;
  const glm::dvec3 axis = normal(0.5, 0.5);
  double angle = 0;
  for (const double u : {0.0, 0.5, 1.0})
    for (const double v : {0.0, 0.5, 1.0}) angle = std::max(angle, std::acos(glm::dot(axis, normal(u, v))));
  TileBounds bounds{-1, 1, {}, static_cast<uint8_t>(std::min(255.0, std::ceil((angle + 0.012) * 510 / 3.14159265)))};
  for (int i = 0; i < 3; ++i) bounds.axis[i] = static_cast<int8_t>(std::lround(127 * axis[i]));
  return bounds;
}

TEST(GlobeSelection, NoTexelInViewIsLargerThanStated) {
  Rng rng(test::randomSeed());
  const FrameTransform frame(earth(14));
  const TileLayer layer = layerOf(1u << 14, 248u << 6);
  ASSERT_TRUE(layer.validate().ok());
  int checked = 0, across = 0;
  double largest_px = 0;
  for (int i = 0; i < 60; ++i) {
    // Above a point, often beside an edge or a corner.
    glm::dvec3 below(rng.uniform(-1, 1), rng.uniform(-1, 1), rng.uniform(-1, 1));
    if (i % 3 == 1) below = {1, 1 + rng.uniform(-0.01, 0.01), rng.uniform(-1, 1)};
    if (i % 3 == 2) below = {1, 1 + rng.uniform(-0.01, 0.01), -1 + rng.uniform(-0.01, 0.01)};
    View view;
    view.pose.eye = frame.spheroid().position(below, std::exp(rng.uniform(7, 17)));
    const glm::dvec3 down = -glm::normalize(below), side = glm::normalize(glm::cross(down, glm::dvec3(0.3, 0.5, 0.8)));
    view.pose.orientation = glm::normalize(glm::quat_cast(glm::dmat3(side, glm::cross(-down, side), -down)) *
                                           glm::angleAxis(rng.uniform(-0.8, 0.8), glm::dvec3(1, 0, 0)));
    view.lens = {.vertical_fov_rad = 1, .width_px = 1600, .height_px = 900};
    view.region_radius_m = i % 2 == 0 ? 0 : 20;
    std::vector<SelectedTile> selected;
    constexpr double kTau = 2;
    selectTiles(
        layer, 0, frame, view, kTau, 100'000,
        [&](const TileId& tile) { return std::optional(boundsOf(layer, frame, tile)); }, selected);
    std::unordered_set<uint64_t> tiles;
    for (const SelectedTile& s : selected) {
      EXPECT_TRUE(layer.isCoarsest(s.tile) || tiles.contains(s.tile.parent().key()));
      tiles.insert(s.tile.key());
    }
    const double focal_px = view.lens.focalPx();
    for (int k = 0; k < 400; ++k) {
      // Through a pixel.
      const glm::dvec2 pixel(rng.uniform(-800, 800), rng.uniform(-450, 450));
      const glm::dvec3 in_view = glm::normalize(glm::dvec3(pixel, -focal_px)), ray = view.pose.orientation * in_view;
      // Where it meets the ellipsoid.
      const glm::dvec3 stretch(1, 1, frame.spheroid().equatorial() / frame.spheroid().polar());
      const glm::dvec3 o = view.pose.eye * stretch / frame.spheroid().equatorial(),
                       d = ray * stretch / frame.spheroid().equatorial();
      const double a = glm::dot(d, d), b = glm::dot(o, d), c = glm::dot(o, o) - 1, root = b * b - a * c;
      if (root <= 0 || b > 0) continue;
      const double distance = (-b - std::sqrt(root)) / a;
      const glm::dvec3 point = view.pose.eye + distance * ray;
      const LatticePosition at = frame.toLattice(point);
      const auto face = static_cast<uint32_t>(at.x / layer.face_steps);
      const double x = at.x - 1.0 * face * layer.face_steps;
      if (x < 1 || at.y < 1 || x > layer.face_steps - 2 || at.y > layer.face_steps - 2) continue;
      uint32_t level = layer.levels();
      for (uint32_t l = 0; l < layer.levels() && level == layer.levels(); ++l) {
        const double tile = kTilePayload * layer.texelAt(l);
        if (tiles.contains(TileId{0, static_cast<uint8_t>(l), layer.xOf(l, face, static_cast<uint32_t>(x / tile)),
                                  static_cast<uint32_t>(at.y / tile)}
                               .key()))
          level = l;
      }
      ASSERT_LT(level, layer.levels()) << "a point in view has no tile";
      if (level == 0) continue;  // the data end
      const double step = layer.texelAt(level) * 0.01;
      const glm::dvec3 along_x = (frame.toScene(LatticePosition{at.x + step, at.y, 0}) - point) / 0.01,
                       along_y = (frame.toScene(LatticePosition{at.x, at.y + step, 0}) - point) / 0.01;
      const double seen = std::fabs(glm::dot(glm::cross(along_x, along_y), ray));
      const double facing = seen / glm::length(glm::cross(along_x, along_y));
      if (facing < 0.06) continue;  // counts as if it were seen less at an angle
      const double size_px = focal_px * std::sqrt(seen / (distance * distance * std::pow(-in_view.z, 3)));
      largest_px = std::max(largest_px, size_px);
      ASSERT_LE(size_px, kTau * 1.001) << "level " << level << " at " << at.x << ", " << at.y;
      ++checked, across += face != static_cast<uint32_t>(frame.toLattice(view.pose.eye).x / layer.face_steps) ? 1 : 0;
    }
  }
  EXPECT_GT(checked, 1000);
  EXPECT_GT(across, 300);
  // Bounds are close enough that not much more is sent than is needed.
  EXPECT_GT(largest_px, 1.2);
}

}  // namespace
}  // namespace foreland::proto
