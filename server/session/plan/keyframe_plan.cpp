#include "server/session/plan/keyframe_plan.h"

#include <algorithm>

namespace foreland::server {

namespace {

// Nearest after the last one that is not to be skipped.
Time nextKeyframe(const KeyframeState& state) {
  if (state.isFirst()) return gridAtOrAfter(state.newest_client, state.grid);
  return gridAtOrAfter(*state.last_client + state.interval - state.grid + Duration{1}, state.grid);
}

// When a predicted keyframe for `t` must leave. The client needs it when it reaches the time of the one before it, or
// of those that it shows before it.
Time sendDeadline(const KeyframeState& state, const ClockMap& clocks, Duration safety, Time t) {
  return clocks.sendBy(t - state.leadTime(state.interval)) - safety;
}

Time earliestKeyframe(const KeyframeState& state) {
  if (state.isFirst()) return {};
  if (state.has_jumped && state.was_after_jump) return state.last_computed + state.grid;
  return state.before_last_computed + Duration{state.grid.us - state.grid.us / 8};
}

KeyframePlan notTooSoon(const KeyframeState& state, KeyframePlan plan) {
  const Time earliest = earliestKeyframe(state);
  plan.due.release = std::max(plan.due.release, earliest);
  plan.due.deadline = std::max(plan.due.deadline, earliest);
  if (plan.due.earliest) plan.due.earliest = std::max(*plan.due.earliest, earliest);
  return plan;
}

// How many grid points lie between the next keyframe and `t`, but no more than real time has gone by, whatever the
// client's clock says.
uint64_t skippedTo(const KeyframeState& state, Time t) {
  const Time next = nextKeyframe(state);
  if (state.isFirst() || t < next) return 0;
  const int64_t most = (state.now - state.last_computed).us / state.grid.us + 1;
  return static_cast<uint64_t>(std::min((t - next).us / state.grid.us, most));
}

KeyframePlan predicted(const KeyframeState& state, const ClockMap& clocks, const PlanOptions& options, Time target) {
  const Time deadline = sendDeadline(state, clocks, options.safety, target);
  Due due{deadline - state.compute_time, deadline, false, state.compute_time};
  if (options.max_early > Duration{} && !state.isFirst()) {
    due.earliest = due.release - std::min(options.max_early, Duration{state.grid.us / 2});
    due.release = std::max(*due.earliest, due.release - options.slack);
  }
  return {target, due, skippedTo(state, target)};
}

// For `delay` and `current` the pose of its time must have arrived.
std::optional<KeyframePlan> refining(const KeyframeState& state, const ClockMap& clocks) {
  const Time last = *state.last_client;
  const Time t = state.predicts ? std::max(last + Duration{1}, clocks.arrivalOf(state.now + state.compute_time))
                                : state.newest_client;
  if (t <= last) return std::nullopt;
  return KeyframePlan{t, {state.now, state.now + Duration{state.grid.us / 2}, false, state.compute_time}};
}

}  // namespace

Time gridAtOrAfter(Time t, Duration grid) {
  const int64_t steps = t.us >= 0 ? (t.us + grid.us - 1) / grid.us : -(-t.us / grid.us);
  return {steps * grid.us};
}

Time targetOf(const KeyframeState& state, const ClockMap& clocks, Duration safety, std::optional<Time> target) {
  const Duration half{state.interval.us / 2};
  if (target && sendDeadline(state, clocks, safety, *target) + half >= state.now) return *target;
  const Time next = nextKeyframe(state);
  const Duration behind = state.now + state.compute_time - sendDeadline(state, clocks, safety, next);
  return behind > Duration{} ? gridAtOrAfter(next + behind, state.grid) : next;
}

std::optional<KeyframePlan> planKeyframe(const KeyframeState& state, const ClockMap& clocks, const PlanOptions& options,
                                         std::optional<Time> target) {
  const Time now = state.now, newest = state.newest_client;
  // After a jump the newest pose counts at once: what is shown was computed for elsewhere.
  if (state.has_jumped) return notTooSoon(state, {newest, {now, now}});
  if (state.is_coarse) return refining(state, clocks);
  if (state.predicts) {
    if (!target) return std::nullopt;
    return notTooSoon(state, predicted(state, clocks, options, *target));
  }
  // The pose of the grid point must have arrived; if those of several have, the newest one counts.
  if (state.isFirst()) return KeyframePlan{newest, {now, now}};
  const Time next = nextKeyframe(state);
  if (newest < next) return std::nullopt;
  const Time latest{next.us + (newest - next).us / state.grid.us * state.grid.us};
  return notTooSoon(
      state, {latest, {now, now + Duration{state.grid.us / 2}, false, state.compute_time}, skippedTo(state, latest)});
}

}  // namespace foreland::server
