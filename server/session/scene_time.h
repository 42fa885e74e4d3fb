// Which scene time each keyframe of a session shows, in scenes with epochs: the viewer's clock, and no epoch passed
// unshown. One owner.
#pragma once

#include <optional>

#include "proto/section/epochs.h"

namespace foreland::server {

class SceneTime {
 public:
  void take(const proto::SceneClock& clock) {
    clock_ = clock;
    is_clock_new_ = true;
  }

  // Of the next keyframe, for the client's time `t`. While the clock runs, no keyframe passes an epoch before one has
  // shown it: between two keyframes the ground then moves linearly in truth, too. Where that is slower than the clock,
  // scene time falls behind.
  Time next(const proto::Epochs& epochs, Time t) {
    const Time wanted = clock_ ? clock_->timeAt(epochs, t) : shown_.value_or(epochs.first());
    shown_ = is_clock_new_ || !shown_ ? wanted : epochs.towards(*shown_, wanted);
    is_clock_new_ = false;
    return *shown_;
  }

 private:
  std::optional<proto::SceneClock> clock_;
  bool is_clock_new_ = false;  // and no keyframe has been computed by it
  std::optional<Time> shown_;  // by the last keyframe
};

}  // namespace foreland::server
