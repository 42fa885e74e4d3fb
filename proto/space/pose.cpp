#include "proto/space/pose.h"

#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>

namespace foreland::proto {

glm::dquat lookAlong(const glm::dvec3& forward, const glm::dvec3& up) {
  const glm::dvec3 back = -glm::normalize(forward);
  glm::dvec3 right = glm::cross(up, back);
  if (glm::dot(right, right) < 1e-12) {  // looking straight up or down: north stays up on the screen
    const glm::dvec3 other = std::fabs(back.y) < 0.9 ? glm::dvec3(0, 1, 0) : glm::dvec3(1, 0, 0);
    right = glm::cross(other, back);
  }
  right = glm::normalize(right);
  return glm::normalize(glm::quat_cast(glm::dmat3(right, glm::cross(back, right), back)));
}

Pose interpolate(const Pose& a, const Pose& b, double weight) {
  return {a.eye + (b.eye - a.eye) * weight, glm::slerp(a.orientation, b.orientation, weight)};
}

}  // namespace foreland::proto
