// Where undulations are looked up (vertical.h): by lattice position; over globes, whose lattice has seams, by longitude
// and latitude in degrees. Pure; any thread.
#pragma once

#include <glm/vec2.hpp>
#include <numbers>

#include "proto/space/frame.h"

namespace foreland::proto {

inline glm::dvec2 undulationPlace(const FrameTransform& transform, glm::dvec2 lattice) {
  if (transform.frame().kind != FrameKind::kGlobe) return lattice;
  const Geodetic at = transform.toGeodetic(transform.toScene(LatticePosition{lattice.x, lattice.y, 0}));
  constexpr double kDegree = std::numbers::pi / 180;
  return {at.longitude_rad / kDegree, at.latitude_rad / kDegree};
}

}  // namespace foreland::proto
