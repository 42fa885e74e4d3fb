#include "client/places.h"

#include <cmath>
#include <glm/common.hpp>
#include <limits>

#include "proto/space/trig.h"

namespace foreland::client {
namespace {

constexpr double kDegreesPerRadian = 57.29577951308232;

}  // namespace

SceneBox boxOf(const proto::Welcome& welcome, const proto::FrameTransform& transform) {
  constexpr int kCells = 8;
  const double quantum_m = welcome.frame.height_quantum_m;
  if (welcome.shape.is_cube) {
    const glm::dvec3 half(glm::dvec2(welcome.frame.semi_major_m), welcome.frame.semiMinor());
    return {-half - welcome.highest * quantum_m, half + welcome.highest * quantum_m};
  }
  SceneBox box{glm::dvec3(std::numeric_limits<double>::infinity()),
               glm::dvec3(-std::numeric_limits<double>::infinity())};
  for (int k = 0; k <= kCells; ++k)
    for (int l = 0; l <= kCells; ++l)
      for (const double height_m : {welcome.lowest * quantum_m, welcome.highest * quantum_m}) {
        const glm::dvec3 p = transform.toScene(proto::LatticePosition{
            (welcome.shape.samples_x - 1.0) * k / kCells, (welcome.shape.samples_y - 1.0) * l / kCells, height_m});
        box = {glm::min(box.low, p), glm::max(box.high, p)};
      }
  return box;
}

std::vector<glm::dvec3> landmarksOf(const proto::Welcome& welcome, const proto::FrameTransform& transform) {
  const auto& shape = welcome.shape;
  if (shape.is_cube) return {};
  const double size = static_cast<double>(1u << shape.root_log2), step = welcome.frame.height_quantum_m;
  std::vector<glm::dvec3> out;
  const auto add = [&](double x, double y, int32_t height) {
    if (x > shape.samples_x - 1.0 || y > shape.samples_y - 1.0) return;
    out.push_back(transform.toScene(proto::LatticePosition{x, y, height * step}));
  };
  for (uint32_t j = 0; j <= shape.roots_y; ++j)
    for (uint32_t i = 0; i <= shape.roots_x; ++i)
      add(i * size, j * size, welcome.corner_heights[j * (shape.roots_x + 1) + i]);
  for (uint32_t j = 0; j < shape.roots_y; ++j)
    for (uint32_t i = 0; i < shape.roots_x; ++i)
      add((i + 0.5) * size, (j + 0.5) * size, welcome.centre_heights[j * shape.roots_x + i]);
  return out;
}

MapPosition mapPositionOf(const proto::FrameTransform& transform, const glm::dvec3& point) {
  const proto::LatticePosition lattice = transform.toLattice(point);
  MapPosition out{.height_m = lattice.height_m, .lattice = {lattice.x, lattice.y}, .up = transform.upAt(point)};
  if (transform.frame().isOnEllipsoid()) {
    const proto::Geodetic geodetic = transform.toGeodetic(point);
    out.across = glm::dvec2(geodetic.latitude_rad, geodetic.longitude_rad) * kDegreesPerRadian;
  } else {
    const glm::dvec2& origin_m = transform.frame().map_origin_m;
    out.across = {origin_m.y + point.y, origin_m.x + point.x};
  }
  return out;
}

glm::dvec3 scenePointOf(const proto::FrameTransform& transform, glm::dvec2 across, double height_m) {
  const proto::Frame& frame = transform.frame();
  if (frame.kind == proto::FrameKind::kPlanar)
    return {across[1] - frame.map_origin_m.x, across[0] - frame.map_origin_m.y, height_m};
  return transform.toScene(proto::Geodetic{.latitude_rad = across[0] / kDegreesPerRadian,
                                           .longitude_rad = across[1] / kDegreesPerRadian,
                                           .height_m = height_m});
}

// East, north and up at the scene's origin, and the origin itself.
std::array<double, 16> ecefOf(const proto::FrameTransform& transform) {
  const proto::Frame& frame = transform.frame();
  const proto::Geodetic at = transform.toGeodetic({0, 0, 0});
  const auto [s, c] = proto::sinCos(at.latitude_rad);
  const auto [sl, cl] = proto::sinCos(at.longitude_rad);
  const double e2 = frame.flattening * (2 - frame.flattening);
  const double across_m = frame.semi_major_m / std::sqrt(1 - e2 * s * s), ring_m = (across_m + at.height_m) * c;
  return {-sl,
          cl,
          0,
          0,  //
          -s * cl,
          -s * sl,
          c,
          0,  //
          c * cl,
          c * sl,
          s,
          0,  //
          ring_m * cl,
          ring_m * sl,
          (across_m * (1 - e2) + at.height_m) * s,
          1};
}

}  // namespace foreland::client
