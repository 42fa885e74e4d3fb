// What a session knows of its keyframes and of the viewer's poses when it plans the next keyframe: a plain value, from
// which plan/keyframe_plan.h computes when that is due, and view/keyframe_view.h for which view. Times of the client's
// clock say so in their names; all others are of the server's.
#pragma once

#include <cstdint>
#include <optional>

#include "base/time.h"

namespace foreland::server {

struct KeyframeState {
  Duration grid;                    // keyframes lie so far apart on the client's clock, or at multiples of that
  Duration interval;                // from the last keyframe to the next
  Duration last_step;               // from the keyframe before the last one to that
  uint32_t order = 1;               // a viewer blends so many keyframes and one more
  bool predicts = false;            // a keyframe is computed before its time (strategy `predict`)
  bool has_jumped = false;          // the camera, and no keyframe has been computed since
  bool was_after_jump = false;      // the last keyframe was the first after a jump
  bool is_coarse = false;           // and coarser than wanted, to be there at once
  Time newest_client;               // of the newest pose
  std::optional<Time> last_client;  // of the last keyframe; nothing before the first one of the connection
  Time last_computed, before_last_computed;            // the last keyframe and the one before it
  Duration compute_time = Duration::milliseconds(10);  // of the slower of the recent keyframes
  Time now;

  bool isFirst() const { return !last_client; }
  // How long before and after its time a keyframe is shown, in part, if keyframes are `between` apart.
  Duration leadTime(Duration between) const { return {between.us * (order + 1) / 2}; }
};

}  // namespace foreland::server
