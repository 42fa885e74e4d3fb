// What a session knows of its viewer's motion: recent poses on the client's clock, and guesses at poses to come (DESIGN
// section 4). One owner. Bounded: it keeps at least the last kCapacity / 2 poses, and at most kCapacity. At 60 poses a
// second these are more than 4 s, so that poses between two keyframes at the usual intervals are all there.
#pragma once

#include <optional>
#include <vector>

#include "proto/message/message.h"
#include "proto/space/pose.h"

namespace foreland::server {

// Motion beyond the newest pose: the eye at constant acceleration, the orientation turning evenly about one axis.
struct Extrapolation {
  glm::dvec3 velocity{0};           // over the last `span_s`, m/s
  glm::dvec3 acceleration{0};       // m/s^2
  glm::dquat rotation{1, 0, 0, 0};  // over the last `span_s`
  double span_s = 1;

  // Radians a second.
  double turnRate() const { return proto::angleBetween(glm::dquat(1, 0, 0, 0), rotation) / span_s; }
};

class PoseHistory {
 public:
  static constexpr size_t kCapacity = 512;
  static constexpr Duration kHorizon = Duration::milliseconds(3000);
  static constexpr Duration kBaseline = Duration::milliseconds(80);

  // A pose that is not newer than the last one is dropped.
  void add(const proto::TimedPose& pose);
  bool empty() const { return poses_.empty(); }
  // Forgets all poses but this one: the camera jumped to it.
  void restart(const proto::TimedPose& pose) { poses_.assign(1, pose); }

  // All that follows needs at least one pose.

  const proto::TimedPose& newest() const { return poses_.back(); }
  // The time that the poses span, at most kBaseline of it being used to tell the velocity.
  Duration span() const { return poses_.back().time - poses_.front().time; }
  // Interpolated between the poses around `t`; the oldest or newest pose outside of their times.
  proto::Pose at(Time t) const;

  // The pose expected at `t`, after the newest one; beyond kHorizon the camera is expected to stand still.
  proto::Pose predict(proto::Predictor predictor, Time t) const;

  // How `predictor` takes the motion to continue.
  //   hold          not at all
  //   velocity      straight and turning evenly, as over the last kBaseline (or more, between sparse poses)
  //   acceleration  velocity changes as it did between the last two such spans; turning stays even
  //   path          as velocity: no path is known here
  Extrapolation extrapolate(proto::Predictor predictor) const;

  // The first time after `t` at which at() or predict() may have a corner; nothing if there is none.
  std::optional<Time> nextCorner(Time t) const;

 private:
  // The index of the newest pose that is at least kBaseline older than that at `i`, or of the oldest one.
  size_t before(size_t i) const;

  std::vector<proto::TimedPose> poses_;  // ascending
};

}  // namespace foreland::server
