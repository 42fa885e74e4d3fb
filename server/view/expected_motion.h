// What a session expects of its viewer's camera, past and future: along the announced path, or as the poses received
// and a predictor say. Besides the pose at a time it tells what a bound over an interval needs: where the motion has
// corners, and how strongly it bends between them. Borrows what it is made of. Const use from any thread.
#pragma once

#include <cstdint>
#include <optional>

#include "proto/space/path.h"
#include "server/view/pose_history.h"

namespace foreland::server {

// The end of step `i` of `steps` equal ones from `begin` to `end`. No interval is so long that it overflows.
inline Time timeBetween(Time begin, Time end, int64_t i, int64_t steps) {
  const int64_t length_us = (end - begin).us;
  return begin + Duration{length_us / steps * i + length_us % steps * i / steps};
}

class ExpectedMotion {
 public:
  // The camera follows `path` at all times.
  explicit ExpectedMotion(const proto::Path& path) : path_(&path) {}
  // The camera was where `history`, which is not empty, says, and moves on from its newest pose as `predictor` says.
  ExpectedMotion(const PoseHistory& history, proto::Predictor predictor) : history_(&history), predictor_(predictor) {}
  // The same, but it moves on as `told` says.
  ExpectedMotion(const PoseHistory& history, const Extrapolation& told) : history_(&history), told_(told) {}

  // Continuous in `t`.
  proto::Pose at(Time t) const;

  // Up to which time it is guessed: later the camera is taken to stand still for want of a guess. Never, along a path.
  std::optional<Time> guessedUntil() const;

  // The first time after `t` at which the motion may have a corner; nothing if there is none. Between two neighbouring
  // corners the eye follows a polynomial of time, and the orientation turns about one axis and one way.
  std::optional<Time> nextCorner(Time t) const;

  // The largest acceleration of the eye in [begin, end], m/s^2. No corner lies inside.
  double maxAcceleration(Time begin, Time end) const;

  // The angle that the orientation turns through from `begin` to `end`, radians; may be more than half a turn. No
  // corner lies inside.
  double turn(Time begin, Time end) const;

 private:
  Extrapolation extrapolation() const { return told_ ? *told_ : history_->extrapolate(predictor_); }

  const proto::Path* path_ = nullptr;
  const PoseHistory* history_ = nullptr;
  proto::Predictor predictor_ = proto::Predictor::kHold;
  std::optional<Extrapolation> told_;
};

}  // namespace foreland::server
