// Axes at right angles that stand on a globe at one place, z upwards: there lines of sight are straight, and the bend
// of the globe is a part of the heights. Value.
#pragma once

#include <cmath>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>

namespace foreland::server {

struct LocalPlane {
  glm::dvec3 origin{0}, x{1, 0, 0}, y{0, 1, 0}, z{0, 0, 1};  // scene frame; metres and unit vectors

  // With this way up; the others' directions do not matter.
  static LocalPlane at(const glm::dvec3& origin, const glm::dvec3& up) {
    const glm::dvec3 beside = std::fabs(up.z) < 0.9 ? glm::dvec3(0, 0, 1) : glm::dvec3(1, 0, 0),
                     x = glm::normalize(glm::cross(beside, up));
    return {origin, x, glm::cross(up, x), up};
  }
  glm::dvec3 direction(const glm::dvec3& v) const { return {glm::dot(x, v), glm::dot(y, v), glm::dot(z, v)}; }
  glm::dvec3 point(const glm::dvec3& p) const { return direction(p - origin); }
};

}  // namespace foreland::server
