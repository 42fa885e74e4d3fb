// The pose at a time between recorded ones. Pure; any thread; portable to WebAssembly.
#pragma once

#include <algorithm>
#include <span>

#include "base/check.h"
#include "proto/space/pose.h"

namespace foreland::proto {

// Interpolates between the two of `poses` around `t`; before the first and after the last it is that one. `poses`
// ascend strictly in time and are not empty. O(log n).
inline Pose poseAt(std::span<const TimedPose> poses, Time t) {
  CHECK_TRUE(!poses.empty());
  const auto after =
      std::lower_bound(poses.begin(), poses.end(), t, [](const TimedPose& p, Time wanted) { return p.time < wanted; });
  if (after == poses.begin()) return poses.front().pose;
  if (after == poses.end()) return poses.back().pose;
  const TimedPose &a = after[-1], &b = *after;
  return interpolate(a.pose, b.pose, static_cast<double>((t - a.time).us) / static_cast<double>((b.time - a.time).us));
}

}  // namespace foreland::proto
