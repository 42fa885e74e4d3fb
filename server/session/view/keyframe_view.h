// For which view a session computes a keyframe: when it is shown, where the camera is expected then, and what it may
// do meanwhile (its region, server/view/region.h).
//
// Pure functions; any thread. Cost: a region's (server/view/region.h).
#pragma once

#include "proto/message/message.h"
#include "server/session/plan/keyframe_state.h"
#include "server/view/viewer_motion.h"

namespace foreland::server {

// When a keyframe for `t` (client's clock) begins to be shown. The first section, and one after a jump, is shown as
// soon as it arrives.
Time shownFrom(const KeyframeState& state, Time t);
// Until when, if the next keyframe is `until_next` later.
inline Time shownUntil(const KeyframeState& state, Time t, Duration until_next) {
  return t + state.leadTime(until_next);
}
// How long a prediction for it must hold.
inline Duration foreseenFor(const KeyframeState& state, Duration until_next) {
  return state.leadTime(std::max(state.interval, until_next));
}

// What the camera, and all eyes about it, stay in while the section for `t` is shown, around where it is expected then.
RegionParts regionFor(const KeyframeState& state, const ViewerMotion& motion, const proto::ViewRequest& request, Time t,
                      Duration until_next);

// The keyframe's view: the pose that is expected at `t`, and what the viewer gets of the region around it.
proto::View viewFor(const ViewerMotion& motion, const proto::ViewRequest& request, double tau_px, Time t,
                    const RegionParts& parts);

// The view as its viewer decodes it from the keyframe's header.
proto::View asDecoded(const proto::View& view, double tau_px);

}  // namespace foreland::server
