// Pictures in which what lies along one direction is drawn longer than it is, about the eye (decision 0066): a point p
// is drawn where the camera would see eye + S(p - eye). Its place along an axis of the camera is dot(axis, S(p - eye)),
// so it is enough to stretch the axes. Value type; any thread.
#pragma once

#include <algorithm>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>

namespace foreland::oracle {

struct Stretch {
  double factor = 1;
  glm::dvec3 along{0, 0, 1};  // unit

  glm::dvec3 operator()(const glm::dvec3& axis) const { return axis + (factor - 1) * glm::dot(axis, along) * along; }
  // By how much any distance is drawn longer, at most.
  double largest() const { return std::max(1.0, factor); }
};

}  // namespace foreland::oracle
