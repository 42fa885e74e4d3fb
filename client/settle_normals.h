// The normals of a section's vertices, from the sums of its triangles' to what is drawn.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>

namespace foreland::client {

inline constexpr uint32_t kNoEnd = 0xffffffffu;

// Makes them unit: normalOf(v), a reference, of `count` vertices. Vertices outside the section lie in the inside of an
// edge there and take the mean of its ends, which stand before them; endsOf(v) of vertices that lie on no edge are
// kNoEnd. What has no length keeps none. O(vertices).
template <class EndsOf, class NormalOf>
void settleNormals(size_t count, const EndsOf& endsOf, const NormalOf& normalOf) {
  for (size_t v = 0; v < count; ++v) {
    glm::dvec3& n = normalOf(v);
    const std::array<uint32_t, 2> ends = endsOf(v);
    if (n == glm::dvec3(0) && ends[0] != kNoEnd) n = normalOf(ends[0]) + normalOf(ends[1]);
    const double length = std::sqrt(glm::dot(n, n));
    if (length > 0) n /= length;
  }
}

}  // namespace foreland::client
