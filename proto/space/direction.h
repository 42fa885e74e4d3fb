// Directions from the middle of a globe, and what lies between two of them. Pure; any thread.
#pragma once

#include <cmath>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>

namespace foreland::proto {

// The angle between two directions of length 1, exact for small ones, too.
inline double angleOf(const glm::dvec3& a, const glm::dvec3& b) {
  return std::atan2(glm::length(glm::cross(a, b)), glm::dot(a, b));
}

// A point on the great circle from a (share 0) to b (1), which have length 1. Between opposite ones it is the nearer.
inline glm::dvec3 directionBetween(const glm::dvec3& a, const glm::dvec3& b, double share) {
  const double angle = angleOf(a, b), sine = std::sin(angle);
  if (angle < 1e-6) return glm::normalize(a + share * (b - a));
  if (sine < 1e-9) return share < 0.5 ? a : b;
  return glm::normalize((std::sin((1 - share) * angle) * a + std::sin(share * angle) * b) / sine);
}

}  // namespace foreland::proto
