#include "server/view/sweep.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

namespace foreland::server {

double angleBetween(const glm::dquat& a, const glm::dquat& b) {
  const glm::dquat d = glm::conjugate(a) * b;
  return 2 * std::asin(std::min(1.0, std::sqrt(d.x * d.x + d.y * d.y + d.z * d.z)));
}

Sweep sweepOf(const proto::Pose& centre, const std::function<proto::Pose(Time)>& pose_at, Time begin, Time end) {
  constexpr int64_t kStep_us = 20'000, kMostSteps = 200;
  const int64_t steps = std::clamp<int64_t>(((end - begin).us + kStep_us - 1) / kStep_us, 1, kMostSteps);
  Sweep sweep, longest;
  proto::Pose last = pose_at(begin);
  for (int64_t i = 0; i <= steps; ++i) {
    const proto::Pose pose = pose_at(begin + Duration{(end - begin).us * i / steps});
    sweep.ball_m = std::max(sweep.ball_m, glm::distance(pose.eye, centre.eye));
    sweep.turn_rad = std::max(sweep.turn_rad, angleBetween(pose.orientation, centre.orientation));
    longest.ball_m = std::max(longest.ball_m, glm::distance(pose.eye, last.eye));
    longest.turn_rad = std::max(longest.turn_rad, angleBetween(pose.orientation, last.orientation));
    last = pose;
  }
  // On a path without kinks the arc between two samples leaves their chord by far less than this.
  return {sweep.ball_m + 0.05 * longest.ball_m, sweep.turn_rad + 0.05 * longest.turn_rad};
}

void PredictionMiss::add(const proto::Pose& predicted, const proto::Pose& actual) {
  misses_[count_++ % kMemory] = {glm::distance(predicted.eye, actual.eye),
                                 angleBetween(predicted.orientation, actual.orientation)};
}

Sweep PredictionMiss::estimate() const {
  Sweep worst;
  for (size_t i = 0; i < std::min(count_, kMemory); ++i) {
    worst.ball_m = std::max(worst.ball_m, 1.5 * misses_[i].ball_m);
    worst.turn_rad = std::max(worst.turn_rad, 1.5 * misses_[i].turn_rad);
  }
  return worst;
}

}  // namespace foreland::server
