// Which scene time each keyframe of a session shows, in scenes with epochs: the viewer's clock, as far as the ground
// between two keyframes may be drawn as the mix of theirs. One owner.
#pragma once

#include <optional>
#include <utility>

#include "proto/section/epochs.h"

namespace foreland::server {

class SceneTime {
 public:
  void take(const proto::SceneClock& clock) {
    clock_ = clock;
    is_clock_new_ = true;
  }

  // Of the next keyframe, for the client's time `t`. While the clock runs, scene time goes from keyframe to keyframe as
  // far as `towards(from, wanted)` lets it: with a linear blend no keyframe passes an epoch before one has shown it
  // (proto::Epochs), with a cubic one steps are short (section/ground_motion.h). Where that is slower than the clock,
  // scene time falls behind. The first keyframe by a clock jumps to its time.
  struct Next {
    Time scene_time;
    bool is_step = false;  // not a jump
  };
  template <class Towards>
  Next next(const proto::Epochs& epochs, Time t, const Towards& towards) {
    const Time wanted = clock_ ? clock_->timeAt(epochs, t) : shown_.value_or(epochs.first());
    const bool is_new = std::exchange(is_clock_new_, false), is_step = shown_ && !is_new;
    shown_ = is_step ? towards(*shown_, wanted) : wanted;
    return {*shown_, is_step};
  }

 private:
  std::optional<proto::SceneClock> clock_;
  bool is_clock_new_ = false;  // and no keyframe has been computed by it
  std::optional<Time> shown_;  // by the last keyframe
};

}  // namespace foreland::server
