// How long after a keyframe the next one follows, where the viewer lets that adapt: as long as the section takes to
// change by a share of its nodes. Where the camera turns or flies low, much of the section changes, keyframes follow
// soon, and little is guessed; where it glides along, a long interval saves the deltas between. One owner (a session).
#pragma once

#include <cstddef>

#include "proto/message/keyframe_interval.h"

namespace foreland::server {

class AdaptiveInterval {
 public:
  static constexpr double kShare = 0.15;  // of the section's nodes that a keyframe should add or remove

  // Notes that a keyframe of `nodes` nodes, `interval` after the one before it, changed so many.
  void observe(size_t changed, size_t nodes, Duration interval);
  // From the keyframe that is about to be computed, `before` after the one before it, to the next: a multiple of the
  // shortest within the bounds, and that one until something was observed. It shortens at once, and lengthens by one
  // step a keyframe: each change of the interval changes the region, and with it the section.
  Duration next(const proto::KeyframeInterval& bounds, Duration before) const;
  // The longest interval that is no longer than `interval` and whose region, which grows with it, needs at most `share`
  // of what that one's does: on the same grid and within the bounds, so the shortest may need more.
  static Duration shortened(const proto::KeyframeInterval& bounds, Duration interval, double share);
  // As before the first keyframe.
  void restart() { share_per_s_ = -1; }

 private:
  double share_per_s_ = -1;  // of the section that changes in a second; below 0: nothing is known
};

}  // namespace foreland::server
