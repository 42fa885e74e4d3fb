// Motion beyond the newest known pose, as a predictor takes it to continue. Value type; any thread.
#pragma once

#include <glm/gtc/quaternion.hpp>
#include <glm/vec3.hpp>

#include "proto/space/pose.h"

namespace foreland::server {

// The eye moves at constant acceleration, the orientation turns evenly about one axis.
struct Extrapolation {
  glm::dvec3 velocity{0};           // over the last `span_s`, m/s
  glm::dvec3 acceleration{0};       // m/s^2
  glm::dquat rotation{1, 0, 0, 0};  // over the last `span_s`
  double span_s = 1;

  // Radians a second.
  double turnRate() const { return proto::angleBetween(glm::dquat(1, 0, 0, 0), rotation) / span_s; }
};

}  // namespace foreland::server
