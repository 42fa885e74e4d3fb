// The normals of an end's drawn vertices from the sums over its section's triangles.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>

namespace foreland::client {

inline constexpr uint32_t kNoVertex = 0xffffffffu;

// Of unit length; a vector of no length stays.
inline glm::dvec3 unitNormal(const glm::dvec3& n) {
  const double length = std::sqrt(glm::dot(n, n));
  return length > 0 ? n / length : n;
}

// Makes unit normals of `count` vertices: of a section's vertices from normalOf(v), a reference to the sum over their
// triangles. A vertex of the union mesh that is no vertex of this section (`isInSection(v)`) lies inside one of its
// edges: it takes the mean of the normals at the edge's endpoints. endpointsOf(v) are smaller than v. O(vertices).
template <class IsInSection, class EndpointsOf, class NormalOf>
void completeNormals(size_t count, const IsInSection& isInSection, const EndpointsOf& endpointsOf,
                     const NormalOf& normalOf) {
  for (size_t v = 0; v < count; ++v) {
    glm::dvec3& n = normalOf(v);
    if (!isInSection(v)) {
      const std::array<uint32_t, 2> endpoints = endpointsOf(v);
      n = normalOf(endpoints[0]) + normalOf(endpoints[1]);
    }
    n = unitNormal(n);
  }
}

}  // namespace foreland::client
