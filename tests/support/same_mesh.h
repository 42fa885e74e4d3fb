// Whether two blended meshes are the same triangles, bit for bit in all that a vertex has, whatever the order of
// triangles and the numbers of vertices.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <bit>
#include <vector>

#include "client/mesh/keyframe_mesh.h"

namespace foreland::test {

using MeshTriangle = std::array<uint32_t, 36>;  // twelve words for each corner

inline std::vector<MeshTriangle> trianglesOf(const client::BlendMesh& mesh) {
  std::vector<MeshTriangle> out;
  for (size_t i = 0; i + 2 < mesh.indices.size(); i += 3) {
    MeshTriangle t;
    for (size_t k = 0; k < 3; ++k) {
      const uint32_t v = mesh.indices[i + k];
      const glm::vec4 &p = mesh.from_positions[v], &q = mesh.to_positions[v];
      const glm::vec2& at = mesh.parameters[v];
      const auto word = [](float value) { return std::bit_cast<uint32_t>(value); };
      const std::array<uint32_t, 12> corner{word(at.x),
                                            word(at.y),
                                            word(p.x),
                                            word(p.y),
                                            word(p.z),
                                            word(p.w),
                                            word(q.x),
                                            word(q.y),
                                            word(q.z),
                                            word(q.w),
                                            mesh.from_normals[v],
                                            mesh.to_normals[v]};
      std::copy(corner.begin(), corner.end(), t.begin() + static_cast<std::ptrdiff_t>(12 * k));
    }
    out.push_back(t);
  }
  std::sort(out.begin(), out.end());
  return out;
}

inline ::testing::AssertionResult isSameMesh(const client::BlendMesh& mesh, const client::BlendMesh& expected) {
  const std::vector<MeshTriangle> all = trianglesOf(mesh), wanted = trianglesOf(expected);
  if (all == wanted) return ::testing::AssertionSuccess();
  auto result = ::testing::AssertionFailure() << all.size() << " triangles, not " << wanted.size();
  const auto [a, b] = std::mismatch(all.begin(), all.end(), wanted.begin(), wanted.end());
  if (a == all.end() || b == wanted.end()) return result;
  for (size_t k = 0; k < 36; ++k)
    if ((*a)[k] != (*b)[k])
      return result << "; the first difference: word " << k % 12 << " of corner " << k / 12 << " at ("
                    << std::bit_cast<float>((*a)[12 * (k / 12)]) << ", "
                    << std::bit_cast<float>((*a)[12 * (k / 12) + 1]) << ") and ("
                    << std::bit_cast<float>((*b)[12 * (k / 12)]) << ", "
                    << std::bit_cast<float>((*b)[12 * (k / 12) + 1]) << ")";
  return result;
}

}  // namespace foreland::test
