// Cones that hold the normals of the ground within a tile, as scene files have them (proto::TileBounds). Rounded
// outward. Pure; any thread.
#pragma once

#include <array>
#include <cstdint>
#include <glm/vec3.hpp>
#include <span>

#include "proto/imagery/tile.h"

namespace foreland::terrain {

// A cone of directions. An axis of zeros holds all of them.
struct NormalCone {
  std::array<int8_t, 3> axis{0, 0, 127};
  uint8_t half_angle = 0;  // of pi / 510

  static NormalCone of(const proto::TileBounds& b) { return {{b.axis[0], b.axis[1], b.axis[2]}, b.half_angle}; }
  static NormalCone everything() { return {{0, 0, 0}, 255}; }
  bool isEverything() const { return axis == std::array<int8_t, 3>{}; }
  glm::dvec3 unitAxis() const;  // not of everything()
  bool holds(const glm::dvec3& unit_normal) const;
  bool holds(const NormalCone& other) const;
  bool operator==(const NormalCone&) const = default;
};

// About `middle` (of any length but 0), with room for normals of which none has a smaller cosine with its stored axis.
std::array<int8_t, 3> quantisedAxis(const glm::dvec3& middle);
NormalCone coneOf(const std::array<int8_t, 3>& axis, double min_cosine);
// A cone that holds all of `cones`, of which there is one at least.
NormalCone unionOf(std::span<const NormalCone> cones);

}  // namespace foreland::terrain
