// What blending of a higher order buys (oracle/reference/order_blend.h): the largest jump of a vertex's velocity on the
// screen where one keyframe joins the blend and another leaves it, and how much later, or further ahead, keyframes are
// needed. One caller.
#pragma once

#include <vector>

#include "oracle/reference/order_blend.h"
#include "proto/space/view.h"
#include "server/section/hierarchy.h"

namespace foreland::lab {

struct OrderFigures {
  oracle::Basis basis = oracle::Basis::kBSpline;
  int order = 1;
  double velocity_jump_max_px_s = 0, velocity_jump_p99_px_s = 0;  // over vertices seen, the camera at rest
  uint64_t joints = 0, vertices = 0;                              // judged
  double lead_ms = 0;  // how long before a moment the last keyframe that its frame blends is needed

  template <class Visit>
  void fields(const Visit& visit) const {
    visit("velocity_jump_max_px_s", velocity_jump_max_px_s);
    visit("velocity_jump_p99_px_s", velocity_jump_p99_px_s);
    visit("joints", joints);
    visit("vertices", vertices);
    visit("lead_ms", lead_ms);
  }
};

// For both bases and the orders 1 to 3, over the keyframes of a flight. `scene_times` are theirs, or empty. Cost: a
// mesh of seven keyframes for each.
std::vector<OrderFigures> measureOrders(const server::Hierarchy& hierarchy, std::span<const proto::View> views,
                                        std::span<const Time> scene_times, Duration interval);

}  // namespace foreland::lab
