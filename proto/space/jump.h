// Distinguishes a camera that jumps (to a landmark, to a shared link's view) from one that moves. No path leads from
// one side of a jump to the other, so motion before it says nothing about motion after it, and no pose between the two
// is ever seen. Pure; any thread; portable to WebAssembly.
#pragma once

#include <algorithm>
#include <glm/geometric.hpp>

#include "proto/space/pose.h"

namespace foreland::proto {

// The fastest motion, a second. At height, cameras move faster, since the ground seems to move slower.
inline constexpr double kFastestMotion_m = 1000, kFastestMotion_heights = 5;
inline constexpr double kFastestTurn_rad = 20;
// A smaller turn between two poses is never a jump: it changes little of what is seen.
inline constexpr double kMinJump_rad = 0.5;

// Whether the camera jumps between two poses, `after` being the later one, at `height_m` above the ground (0 if
// unknown).
inline bool isJump(const TimedPose& before, const TimedPose& after, double height_m) {
  const double seconds = (after.time - before.time).toSeconds();
  const double turn_rad = angleBetween(before.pose.orientation, after.pose.orientation);
  return glm::distance(before.pose.eye, after.pose.eye) >
             seconds * std::max(kFastestMotion_m, kFastestMotion_heights * height_m) ||
         turn_rad > std::max(kMinJump_rad, seconds * kFastestTurn_rad);
}

}  // namespace foreland::proto
