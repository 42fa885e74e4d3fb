// Where a ray meets the ground that is held. Pure; any thread; portable to WebAssembly.
#pragma once

#include <glm/vec3.hpp>
#include <optional>

#include "client/ground/ground_heights.h"
#include "proto/space/frame.h"

namespace foreland::client {

struct Ray {
  glm::dvec3 origin, direction;  // scene frame; the direction of any length but 0
  double far_m;                  // no further than this; may be infinite
};

// The first point of a ray that is not above the ground, within a box about the data (scene frame). Sought in 4096
// steps through the box, so what is thinner than a step may be missed; found to far less than a step.
std::optional<glm::dvec3> rayOnGround(const GroundHeights& ground, const proto::FrameTransform& frame,
                                      const glm::dvec3& low, const glm::dvec3& high, const Ray& ray);

}  // namespace foreland::client
