// When a session computes its next keyframe, and for which time.
//
// Keyframes lie on a grid of the client's clock (THEORY section 4). With `predict`, the keyframe for t_{i+1} is
// computed so that it arrives by t_i; with `delay` and `current`, that for t_i is computed when the pose of t_i has
// arrived. A viewer that blends n + 1 keyframes shows what is in the middle of them (KeyframeState::leadTime), so with
// `predict` its keyframes are computed (n - 1) / 2 intervals sooner. If viewer, link or server cannot keep up, grid
// points are skipped.
//
// After a jump a coarse keyframe is computed at once, and the one that refines it as soon as that has left, for the
// time at which it arrives: not on the grid, for nothing else is shown.
//
// Pure functions; any thread; O(1).
#pragma once

#include <cstdint>
#include <optional>

#include "server/sched/due.h"
#include "server/session/input/clock_map.h"
#include "server/session/plan/keyframe_state.h"

namespace foreland::server {

struct PlanOptions {
  Duration safety;     // a predicted keyframe should arrive this long before it is needed
  Duration max_early;  // it may be computed so much earlier than it must be begun, but at most half an interval; 0: not
  Duration slack;      // and is always begun so much earlier where that is permitted (decision 0024)
};

struct KeyframePlan {
  Time time_client;
  Due due;
  uint64_t skipped = 0;  // grid points without a keyframe
};

// The first time of the client's grid at or after `t`.
Time gridAtOrAfter(Time t, Duration grid);

// Which grid point the next keyframe is for, with `predict`: `target`, the one that was chosen before, until its
// keyframe would be late by more than half an interval; else the nearest that can be in time.
Time targetOf(const KeyframeState& state, const ClockMap& clocks, Duration safety, std::optional<Time> target);

// The next keyframe; nothing if it waits for a pose or, with `predict`, has no target. Keyframes are an interval apart
// on the client's clock. Whatever that clock says, hardly more than two of them are computed in an interval of the
// server's, and as many if the camera jumps every time.
std::optional<KeyframePlan> planKeyframe(const KeyframeState& state, const ClockMap& clocks, const PlanOptions& options,
                                         std::optional<Time> target);

}  // namespace foreland::server
