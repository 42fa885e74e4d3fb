#include "server/view/prediction_errors.h"

#include <algorithm>
#include <glm/geometric.hpp>

namespace foreland::server {

void PredictionErrors::add(const proto::Pose& predicted, const proto::Pose& actual) {
  errors_[count_++ % kMemory] = {glm::distance(predicted.eye, actual.eye),
                                 proto::angleBetween(predicted.orientation, actual.orientation)};
}

Region PredictionErrors::estimate() const {
  Region worst;
  for (size_t i = 0; i < std::min(count_, kMemory); ++i) {
    worst.radius_m = std::max(worst.radius_m, kSafety * errors_[i].radius_m);
    worst.angle_rad = std::max(worst.angle_rad, kSafety * errors_[i].angle_rad);
  }
  return worst;
}

}  // namespace foreland::server
