#include "proto/imagery/tile_selection.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "proto/refine/frustum.h"

namespace foreland::proto {

namespace {

// A texel that is seen at a grazing angle counts as if it were seen at one of three degrees.
constexpr double kLeastCosine = 0.05;
constexpr double kNearest_m = 0.01;
constexpr double kQuarterTurn = 1.57079632679489662, kHalfTurn = 2 * kQuarterTurn;

class Selection {
 public:
  Selection(const TileLayer& layer, const FrameTransform& frame, const View& view)
      : layer_(layer), frame_(frame), view_(view), frustum_(view, kNearest_m), eye_(frame.toLattice(view.pose.eye)) {
    focal_px_ = view.lens.height_px / (2 * view.lens.tanHalfFov());
  }

  // The largest size on the screen of a texel of the tile; nothing if the tile is out of view.
  std::optional<double> texelSize(const TileId& tile, const TileBounds& bounds) const {
    const LatticeBox box = layer_.boxOf(tile);
    const glm::dvec2 middle = 0.5 * (box.low + box.high);
    const double middle_m = 0.5 * (double{bounds.lowest_m} + bounds.highest_m);
    const glm::dvec3 centre = frame_.toScene(LatticePosition{middle.x, middle.y, middle_m});
    const double radius = radiusOf(box, bounds, centre) + view_.region_radius_m;
    const glm::dvec3 from_eye = centre - view_.pose.eye;
    const ViewPosition p = frustum_.toView(from_eye.x, from_eye.y, from_eye.z);
    const double distance = glm::length(from_eye);
    if (distance > radius && frustum_.sideDistance(p) < -radius) return std::nullopt;
    const double spread = distance <= radius ? kHalfTurn : std::asin(radius / distance);
    const double size_px =
        spacing(middle, middle_m) * layer_.texelAt(tile.level) * focal_px_ / nearestDistance(box, bounds);
    const glm::dvec3 up = frame_.toScene(LatticePosition{middle.x, middle.y, middle_m + 1}) - centre;
    return size_px * stretch(p, distance, spread) *
           std::sqrt(largestCosine(bounds, from_eye, distance, spread) / leastUprightness(bounds, up));
  }

 private:
  double radiusOf(const LatticeBox& box, const TileBounds& bounds, const glm::dvec3& centre) const {
    double radius = 0;
    for (const double x : {box.low.x, box.high.x})
      for (const double y : {box.low.y, box.high.y})
        for (const float h : {bounds.lowest_m, bounds.highest_m})
          radius = std::max(radius, glm::distance(centre, frame_.toScene(LatticePosition{x, y, h})));
    return radius;
  }

  // Metres between samples: the longer of both axes.
  double spacing(const glm::dvec2& at, double height_m) const {
    const glm::dvec3 here = frame_.toScene(LatticePosition{at.x, at.y, height_m});
    return std::max(glm::distance(here, frame_.toScene(LatticePosition{at.x + 1, at.y, height_m})),
                    glm::distance(here, frame_.toScene(LatticePosition{at.x, at.y + 1, height_m})));
  }

  // From anywhere that the eye may be to the box of the tile's ground.
  double nearestDistance(const LatticeBox& box, const TileBounds& bounds) const {
    const LatticePosition nearest{std::clamp(eye_.x, box.low.x, box.high.x), std::clamp(eye_.y, box.low.y, box.high.y),
                                  std::clamp<double>(eye_.height_m, bounds.lowest_m, bounds.highest_m)};
    return std::max(glm::distance(view_.pose.eye, frame_.toScene(nearest)) - view_.region_radius_m, kNearest_m);
  }

  // Between a normal of the tile and the direction to the eye, where that is smallest.
  static double largestCosine(const TileBounds& bounds, const glm::dvec3& from_eye, double distance, double spread) {
    const glm::dvec3 axis(bounds.axis[0], bounds.axis[1], bounds.axis[2]);
    const double length = glm::length(axis);
    if (length < 1 || spread >= kQuarterTurn) return 1;
    const double angle = std::acos(std::clamp(-glm::dot(axis, from_eye) / (length * distance), -1.0, 1.0));
    const double least = angle - bounds.half_angle * (kQuarterTurn / 255) - spread;
    return std::max(kLeastCosine, std::cos(std::clamp(least, 0.0, kQuarterTurn)));
  }

  // Of the tile's steepest ground: a texel on it is so much longer. Slopes over 60 degrees count as such.
  static double leastUprightness(const TileBounds& bounds, const glm::dvec3& up) {
    constexpr double kLeast = 0.5;
    const glm::dvec3 axis(bounds.axis[0], bounds.axis[1], bounds.axis[2]);
    const double length = glm::length(axis);
    if (length < 1) return kLeast;
    const double tilt = std::acos(std::clamp(glm::dot(axis, up) / length, -1.0, 1.0));
    return std::max(kLeast, std::cos(std::min(tilt + bounds.half_angle * (kQuarterTurn / 255), kQuarterTurn)));
  }

  // How much larger things are on a plane screen at an angle from its middle, at the tile's visible point where that is
  // largest: by 1 / cos across the angle and 1 / cos^2 along it, the distance being the same.
  double stretch(const ViewPosition& p, double distance, double spread) const {
    const double middle = distance > 0 ? std::acos(std::clamp(p.z / distance, -1.0, 1.0)) : 0;
    const double farthest = std::min(middle + spread + view_.region_angle_rad, kQuarterTurn);
    return std::pow(std::max(frustum_.cosCorner(), std::cos(farthest)), -1.5);
  }

  const TileLayer& layer_;
  const FrameTransform& frame_;
  const View& view_;
  Frustum frustum_;
  LatticePosition eye_;
  double focal_px_;
};

}  // namespace

void selectTiles(const TileLayer& layer, uint8_t layer_index, const FrameTransform& frame, const View& view,
                 double tau_texel_px, size_t most, const TileLookup& lookup, std::vector<SelectedTile>& out) {
  out.clear();
  const Selection selection(layer, frame, view);
  // Within a tile the texels of its parent are twice as large as its own.
  const auto consider = [&](const TileId& tile) {
    if (!layer.has(tile)) return;
    const auto bounds = lookup(tile);
    if (!bounds) return;
    const auto size = selection.texelSize(tile, *bounds);
    if (size && (layer.isCoarsest(tile) || 2 * *size > tau_texel_px)) out.push_back({tile, static_cast<float>(*size)});
  };
  consider({layer_index, static_cast<uint8_t>(layer.levels() - 1), 0, 0});
  // Level by level; `from` is the first tile of the level before.
  size_t from = 0;
  while (from < out.size() && out.size() < most && out[from].tile.level > 0) {
    const size_t end = out.size();
    for (size_t i = from; i < end; ++i) {
      const TileId t = out[i].tile;
      for (uint32_t k = 0; k < 4; ++k) consider(t.child(k));
    }
    from = end;
    std::sort(out.begin() + static_cast<ptrdiff_t>(from), out.end(), [](const SelectedTile& a, const SelectedTile& b) {
      return a.texel_px != b.texel_px ? a.texel_px > b.texel_px : a.tile.key() < b.tile.key();
    });
  }
  if (out.size() > most) out.resize(most);
}

}  // namespace foreland::proto
