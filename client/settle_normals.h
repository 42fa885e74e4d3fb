// The normals of a section's vertices, from the sums of its triangles' to what is drawn.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>
#include <vector>

namespace foreland::client {

inline constexpr uint32_t kNoEnd = 0xffffffffu;

// Makes them unit. Vertices outside the section lie in the inside of an edge there and take the mean of its ends, which
// stand before them; `ends` of vertices that lie on no edge are kNoEnd. What has no length keeps none. O(vertices).
inline void settleNormals(const std::vector<std::array<uint32_t, 2>>& ends, std::vector<glm::dvec3>& normals) {
  for (size_t v = 0; v < normals.size(); ++v) {
    glm::dvec3& n = normals[v];
    if (n == glm::dvec3(0) && ends[v][0] != kNoEnd) n = normals[ends[v][0]] + normals[ends[v][1]];
    const double length = std::sqrt(glm::dot(n, n));
    if (length > 0) n /= length;
  }
}

}  // namespace foreland::client
