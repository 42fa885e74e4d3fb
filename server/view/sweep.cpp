#include "server/view/sweep.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

namespace foreland::server {

Sweep sweepOf(const proto::Pose& centre, const std::function<proto::Pose(Time)>& pose_at, Time begin, Time end) {
  constexpr int64_t kStep_us = 20'000, kMostSteps = 200;
  const int64_t steps = std::clamp<int64_t>(((end - begin).us + kStep_us - 1) / kStep_us, 1, kMostSteps);
  Sweep sweep, longest;
  proto::Pose last = pose_at(begin);
  for (int64_t i = 0; i <= steps; ++i) {
    const proto::Pose pose = pose_at(begin + Duration{(end - begin).us * i / steps});
    sweep.region_radius_m = std::max(sweep.region_radius_m, glm::distance(pose.eye, centre.eye));
    sweep.region_angle_rad =
        std::max(sweep.region_angle_rad, proto::angleBetween(pose.orientation, centre.orientation));
    longest.region_radius_m = std::max(longest.region_radius_m, glm::distance(pose.eye, last.eye));
    longest.region_angle_rad =
        std::max(longest.region_angle_rad, proto::angleBetween(pose.orientation, last.orientation));
    last = pose;
  }
  // On a path without kinks the arc between two samples leaves their chord by far less than this.
  return {sweep.region_radius_m + 0.05 * longest.region_radius_m,
          sweep.region_angle_rad + 0.05 * longest.region_angle_rad};
}

void PredictionErrors::add(const proto::Pose& predicted, const proto::Pose& actual) {
  errors_[count_++ % kMemory] = {glm::distance(predicted.eye, actual.eye),
                                 proto::angleBetween(predicted.orientation, actual.orientation)};
}

Sweep PredictionErrors::estimate() const {
  Sweep worst;
  for (size_t i = 0; i < std::min(count_, kMemory); ++i) {
    worst.region_radius_m = std::max(worst.region_radius_m, 1.5 * errors_[i].region_radius_m);
    worst.region_angle_rad = std::max(worst.region_angle_rad, 1.5 * errors_[i].region_angle_rad);
  }
  return worst;
}

}  // namespace foreland::server
