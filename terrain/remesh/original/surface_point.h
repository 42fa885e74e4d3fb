// A point of a triangle mesh, as a face and barycentric weights, and small geometry of triangles. Value types; any
// thread.
#pragma once

#include <cstdint>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <vector>

#include "terrain/remesh/original/original.h"

namespace foreland::terrain {

struct SurfacePoint {
  uint32_t face = kNoIndex;
  glm::dvec3 weights{1, 0, 0};  // barycentric, of the face's corners; not negative, sum 1
};

inline glm::dvec3 positionOf(const SurfacePoint& at, const std::vector<glm::dvec3>& positions,
                             const std::vector<Triangle>& faces) {
  const Triangle& t = faces[at.face];
  return at.weights.x * positions[t[0]] + at.weights.y * positions[t[1]] + at.weights.z * positions[t[2]];
}

// Weights corrected for rounding: none negative, sum 1.
inline glm::dvec3 cleanWeights(const glm::dvec3& weights) {
  const glm::dvec3 w = glm::max(weights, glm::dvec3(0));
  return w / (w.x + w.y + w.z);
}

// Twice the signed area of a triangle in the plane.
inline double cross2(const glm::dvec2& a, const glm::dvec2& b) { return a.x * b.y - a.y * b.x; }
inline double doubledArea(const glm::dvec2& a, const glm::dvec2& b, const glm::dvec2& c) {
  return cross2(b - a, c - a);
}

// Barycentric weights of `p` in the triangle a, b, c, which has an area; negative outside.
inline glm::dvec3 weightsIn(const glm::dvec2& p, const glm::dvec2& a, const glm::dvec2& b, const glm::dvec2& c) {
  const double all = doubledArea(a, b, c);
  const double wa = doubledArea(p, b, c) / all, wb = doubledArea(a, p, c) / all;
  return {wa, wb, 1 - wa - wb};
}

// Unit normal of a face that has an area.
inline glm::dvec3 normalOf(const Triangle& t, const std::vector<glm::dvec3>& positions) {
  return glm::normalize(glm::cross(positions[t[1]] - positions[t[0]], positions[t[2]] - positions[t[0]]));
}

}  // namespace foreland::terrain
