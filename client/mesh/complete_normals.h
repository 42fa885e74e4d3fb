// Turns the sums of a section's triangle normals into one unit normal for each drawn vertex.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>

namespace foreland::client {

inline constexpr uint32_t kNoVertex = 0xffffffffu;

// Normalises normalOf(v), a reference to the sum over the triangles at vertex v, for `count` vertices. A vertex of the
// union mesh that is no vertex of this section lies inside one of its edges and has no sum: it takes the mean of the
// normals at the edge's endpoints. endpointsOf(v) are smaller than v, or kNoVertex for base vertices. A sum of no
// length stays zero. O(vertices).
template <class EndpointsOf, class NormalOf>
void completeNormals(size_t count, const EndpointsOf& endpointsOf, const NormalOf& normalOf) {
  for (size_t v = 0; v < count; ++v) {
    glm::dvec3& n = normalOf(v);
    const std::array<uint32_t, 2> endpoints = endpointsOf(v);
    if (n == glm::dvec3(0) && endpoints[0] != kNoVertex) n = normalOf(endpoints[0]) + normalOf(endpoints[1]);
    const double length = std::sqrt(glm::dot(n, n));
    if (length > 0) n /= length;
  }
}

}  // namespace foreland::client
