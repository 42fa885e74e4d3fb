#include "server/session/view/keyframe_view.h"

#include <algorithm>

#include "proto/message/compact.h"

namespace foreland::server {

namespace {

// For how many intervals the first keyframe after a jump is expected to be shown.
constexpr int64_t kShownAfterJump = 5;

}  // namespace

Time shownFrom(const KeyframeState& state, Time t) {
  if (state.has_jumped) return state.newest_client;
  if (state.isFirst()) return std::min(state.newest_client, t - state.leadTime(state.grid));
  return std::min(*state.last_client, t - state.grid) - (state.leadTime(state.last_step) - state.last_step);
}

RegionParts regionFor(const KeyframeState& state, const ViewerMotion& viewer, const proto::ViewRequest& request, Time t,
                      Duration until_next) {
  const ExpectedMotion motion = viewer.expected(request);
  const Time end = shownUntil(state, t, until_next);
  const Duration unknown = state.has_jumped ? state.grid * kShownAfterJump : end - state.newest_client;
  RegionParts parts =
      viewer.regionAround(motion.at(t), motion, shownFrom(state, t), end, foreseenFor(state, until_next), unknown);
  parts.rest.radius_m += request.eye_radius_m;
  return parts;
}

proto::View viewFor(const ViewerMotion& motion, const proto::ViewRequest& request, double tau_px, Time t,
                    const RegionParts& parts) {
  proto::View view{motion.expected(request).at(t), request.lens, tau_px};
  const Region region = motion.regionShare().of(parts);
  // Floats, as in the keyframe's header.
  view.region_radius_m = static_cast<float>(region.radius_m);
  view.region_angle_rad = static_cast<float>(region.angle_rad);
  return view;
}

proto::View asDecoded(const proto::View& view, double tau_px) {
  return {proto::asSentInHeader(view.pose), view.lens, tau_px, proto::shortAtLeast(view.region_radius_m),
          proto::shortAtLeast(view.region_angle_rad)};
}

}  // namespace foreland::server
