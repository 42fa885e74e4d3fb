// A planned path of the camera: poses at even steps of time, smooth in between. Both ends evaluate it to the same
// poses, so a keyframe predicted from it has no extrapolation error (THEORY section 4, `known path`). Value type; const
// use from any thread.
#pragma once

#include <optional>
#include <vector>

#include "base/result.h"
#include "proto/space/pose.h"

namespace foreland::proto {

struct Path {
  static constexpr size_t kMaxPoses = 100'000;

  Time start;  // the client's clock
  Duration step = Duration::milliseconds(100);
  std::vector<Pose> poses;  // at start, start + step, ...

  Time end() const { return start + step * static_cast<int64_t>(poses.empty() ? 0 : poses.size() - 1); }
  // Catmull-Rom through the eyes, slerp between orientations; before the start and after the end the path holds still.
  Pose at(Time t) const;
  // The time of the first pose after `t`; nothing after the last one. Between two neighbouring poses the path is
  // smooth.
  std::optional<Time> nextPoseTime(Time t) const;
  // The largest acceleration of the eye in [begin, end], metres per second squared. No pose lies inside.
  double maxAcceleration(Time begin, Time end) const;
  // Two to kMaxPoses usable poses, a step of 1 ms to 60 s.
  Status validate() const;
};

}  // namespace foreland::proto
