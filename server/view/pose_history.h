// What a session knows of its viewer's motion: recent poses on the client's clock, and guesses at poses to come (DESIGN
// section 4). One owner. Bounded: the last kCapacity poses.
#pragma once

#include <optional>
#include <vector>

#include "proto/message/message.h"
#include "proto/space/path.h"

namespace foreland::server {

class PoseHistory {
 public:
  static constexpr size_t kCapacity = 64;

  // Poses that are not newer than the last one are dropped.
  void add(const proto::TimedPose& pose);
  bool empty() const { return poses_.empty(); }
  const proto::TimedPose& newest() const { return poses_.back(); }
  // Between the poses around `t`; the oldest or newest pose beyond them. Not empty.
  proto::Pose at(Time t) const;

  // The pose expected at `t`, which may be ahead of the newest one by up to kHorizon (later times are cut to it). Not
  // empty.
  //   hold          the newest pose
  //   velocity      its motion goes on: straight and turning evenly
  //   acceleration  so does its change of speed; turning stays even
  //   path          the announced path; constant velocity if there is none
  proto::Pose predict(proto::Predictor predictor, const std::optional<proto::Path>& path, Time t) const;

  static constexpr Duration kHorizon = Duration::milliseconds(3000);

 private:
  // The newest pose that is at least kBaseline older than the one at `i`, or the oldest.
  size_t before(size_t i) const;
  static constexpr Duration kBaseline = Duration::milliseconds(80);

  std::vector<proto::TimedPose> poses_;  // ascending
};

}  // namespace foreland::server
