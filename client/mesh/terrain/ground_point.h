// A point of the ground as it is drawn: where it is, and in scenes that change in time how far it has moved since the
// first epoch. All parts are blended alike (blend_position.h), so a colour by change is as true as the geometry: where
// both the ground and the first epoch's keep a tolerance, their difference keeps twice that. Value; any thread.
#pragma once

#include <glm/vec3.hpp>

#include "client/mesh/terrain/end_heights.h"
#include "proto/refine/metric/terrain_domain.h"

namespace foreland::client {

struct GroundPoint {
  glm::dvec3 position{0};  // scene frame, metres
  double height_m = 0;     // above the zero surface
  double moved_m = 0;      // upwards, since the first epoch

  bool operator==(const GroundPoint&) const = default;
};

inline GroundPoint operator+(const GroundPoint& a, const GroundPoint& b) {
  return {a.position + b.position, a.height_m + b.height_m, a.moved_m + b.moved_m};
}
inline GroundPoint operator-(const GroundPoint& a, const GroundPoint& b) {
  return {a.position - b.position, a.height_m - b.height_m, a.moved_m - b.moved_m};
}
inline GroundPoint operator*(double k, const GroundPoint& a) { return {k * a.position, k * a.height_m, k * a.moved_m}; }

// A vertex at the mesh's beginning (0) or its end (1); `height` is that of its record or of the base, quanta.
inline GroundPoint groundPointAt(const proto::TerrainDomain& domain, const EndHeights& heights, proto::NodeId v,
                                 int32_t height, size_t end) {
  const double moved = heights.moved(v, end), quanta = height + moved,
               quantum_m = domain.frame.transform().frame().height_quantum_m;
  return {domain.frame.position(v, quanta), quanta * quantum_m, moved * quantum_m};
}

}  // namespace foreland::client
