#include "server/view/prediction_errors.h"

#include <algorithm>
#include <glm/geometric.hpp>

namespace foreland::server {

void PredictionErrors::add(const proto::Pose& predicted, const proto::Pose& actual, Duration interval) {
  errors_[count_++ % kMemory] = {
      {glm::distance(predicted.eye, actual.eye), proto::angleBetween(predicted.orientation, actual.orientation)},
      interval};
}

Region PredictionErrors::estimate(Duration interval) const {
  Region worst;
  for (size_t i = 0; i < std::min(count_, kMemory); ++i) {
    const double scale = static_cast<double>(interval.us) / static_cast<double>(errors_[i].interval.us);
    worst.radius_m = std::max(worst.radius_m, kSafety * scale * errors_[i].error.radius_m);
    worst.angle_rad = std::max(worst.angle_rad, kSafety * scale * errors_[i].error.angle_rad);
  }
  return worst;
}

}  // namespace foreland::server
