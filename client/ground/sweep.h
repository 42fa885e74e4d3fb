// How far a camera may move over the ground. Pure; any thread; portable to WebAssembly.
//
// The path is exact, not sampled: over a cell of known heights the highest surface that any triangulation of it may
// have is two planes, so along a straight line it rises and falls in straight pieces, which are met in turn. So nothing
// thin is passed through, at any speed, and what is drawn of full-resolution ground is never met.
#pragma once

#include <glm/vec3.hpp>

#include "client/ground/ground_heights.h"
#include "proto/space/frame.h"

namespace foreland::client {

// Where an eye comes to that moves from `from` towards `to` (scene frame, metres) and stays `clearance_m` above the
// ground as far as it is known. What ends above it everywhere ends at `to`, to the bit. Where the ground is in the way
// the eye glides along it, and never travels further than from `from` to `to`.
//
// Only the motion is limited. An eye that does not move stays, to the bit, whatever becomes known of the ground; one
// that is too low then, by d, is lifted by no more than it moves sideways, until it is free, and sinks no deeper.
// O(cells under the path).
glm::dvec3 sweep(const GroundHeights& ground, const proto::FrameTransform& frame, const glm::dvec3& from,
                 const glm::dvec3& to, double clearance_m);

}  // namespace foreland::client
