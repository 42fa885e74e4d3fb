// A bound of where the eye will be: tighter than a region's ball (region.h) for a camera that flies on. Pure functions;
// any thread.
#pragma once

#include <glm/vec3.hpp>
#include <span>

#include "server/view/expected_motion.h"

namespace foreland::server {

// All eyes within `radius_m` of the segment from `eye` to `eye + way`. Scene frame, metres.
struct EyeCapsule {
  glm::dvec3 eye{0}, way{0};
  double radius_m = 0;

  bool contains(const EyeCapsule& other) const;
};

// A capsule that contains all of `parts`, at least one, that follow one another.
EyeCapsule hullOf(std::span<const EyeCapsule> parts);

// A capsule along the chord from motion.at(begin) to motion.at(end) that holds the eye at all times between, up to
// rounding of less than a micrometre. Cost: one pose each 20 ms (at most 16), and one for each corner of the motion.
EyeCapsule capsuleOf(const ExpectedMotion& motion, Time begin, Time end);

}  // namespace foreland::server
