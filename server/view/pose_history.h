// What a session knows of its viewer's motion: recent poses on the client's clock, and guesses at poses to come (THEORY
// section 4). One owner. Bounded: it keeps at least the last kCapacity / 2 poses, and at most kCapacity. At 60 poses a
// second these are more than 4 s, so that poses between two keyframes at the usual intervals are all there.
#pragma once

#include <optional>
#include <vector>

#include "proto/message/message.h"
#include "proto/space/pose.h"
#include "server/view/extrapolation.h"
#include "server/view/motion_filters.h"

namespace foreland::server {

class PoseHistory {
 public:
  static constexpr size_t kCapacity = 512;
  static constexpr Duration kHorizon = Duration::milliseconds(3000);
  static constexpr Duration kBaseline = Duration::milliseconds(80);

  // A pose that is not newer than the last one is dropped.
  void add(const proto::TimedPose& pose);
  bool empty() const { return poses_.empty(); }
  // Forgets all poses but this one: the camera jumped to it.
  void restart(const proto::TimedPose& pose);

  // All that follows needs at least one pose.

  const proto::TimedPose& newest() const { return poses_.back(); }
  // The time that the poses span, at most kBaseline of it being used to tell the velocity.
  Duration span() const { return poses_.back().time - poses_.front().time; }
  // Interpolated between the poses around `t`; the oldest or newest pose outside of their times.
  proto::Pose at(Time t) const;

  // The pose expected at `t`, after the newest one; beyond kHorizon the camera is expected to stand still.
  proto::Pose predict(proto::Predictor predictor, Time t) const;
  // The same, of a camera that moves on as `motion` says.
  proto::Pose predict(const Extrapolation& motion, Time t) const;

  // How `predictor` takes the motion to continue.
  //   hold          not at all
  //   velocity      straight and turning evenly, as over the last kBaseline (or more, between sparse poses)
  //   acceleration  velocity changes as it did between the last two such spans; turning stays even
  //   double exponential, Kalman
  //                 by rates filtered over all poses since the last restart (motion_filters.h)
  //   path          as velocity: no path is known here
  Extrapolation extrapolate(proto::Predictor predictor) const;

  // The first time after `t` at which at() or predict() may have a corner; nothing if there is none.
  std::optional<Time> nextCorner(Time t) const;

 private:
  // The index of the newest pose that is at least kBaseline older than that at `i`, or of the oldest one.
  size_t before(size_t i) const;

  std::vector<proto::TimedPose> poses_;  // ascending
  DoubleExponential double_exponential_;
  std::optional<KalmanMotion> kalman_;  // from the first pose on
};

}  // namespace foreland::server
