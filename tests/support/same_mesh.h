// Whether two blended meshes are the same triangles, bit for bit in all that a vertex has, whatever the order of
// triangles and the numbers of vertices. Triangles with three times the same corner are none.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <bit>
#include <vector>

#include "client/mesh/patch/blend_patch.h"

namespace foreland::test {

inline constexpr size_t kWords = 20;  // for each corner
using MeshTriangle = std::array<uint32_t, 3 * kWords>;

inline std::vector<MeshTriangle> trianglesOf(const client::BlendMesh& mesh) {
  std::vector<MeshTriangle> out;
  for (size_t i = 0; i + 2 < mesh.indices.size(); i += 3) {
    if (mesh.indices[i] == mesh.indices[i + 1] && mesh.indices[i] == mesh.indices[i + 2]) continue;
    MeshTriangle t;
    for (size_t k = 0; k < 3; ++k) {
      const uint32_t v = mesh.indices[i + k];
      const glm::vec4 &p = mesh.from_positions[v], &q = mesh.to_positions[v];
      const glm::vec2& at = mesh.parameters[v];
      const client::BlendPatch::Bend bend = mesh.from_bends.empty()
                                                ? client::BlendPatch::Bend{}
                                                : client::BlendPatch::Bend{mesh.from_bends[v], mesh.to_bends[v]};
      const auto word = [](float value) { return std::bit_cast<uint32_t>(value); };
      const std::array<uint32_t, kWords> corner{word(at.x),
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
                                                mesh.to_normals[v],
                                                word(mesh.from_moved.empty() ? 0 : mesh.from_moved[v]),
                                                word(mesh.to_moved.empty() ? 0 : mesh.to_moved[v]),
                                                word(bend.from.x),
                                                word(bend.from.y),
                                                word(bend.from.z),
                                                word(bend.to.x),
                                                word(bend.to.y),
                                                word(bend.to.z)};
      std::copy(corner.begin(), corner.end(), t.begin() + static_cast<std::ptrdiff_t>(kWords * k));
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
  for (size_t k = 0; k < 3 * kWords; ++k)
    if ((*a)[k] != (*b)[k])
      return result << "; the first difference: " << std::bit_cast<float>((*a)[k]) << " and "
                    << std::bit_cast<float>((*b)[k]) << " in word " << k % kWords << " of corner " << k / kWords
                    << " at (" << std::bit_cast<float>((*a)[kWords * (k / kWords)]) << ", "
                    << std::bit_cast<float>((*a)[kWords * (k / kWords) + 1]) << ") and ("
                    << std::bit_cast<float>((*b)[kWords * (k / kWords)]) << ", "
                    << std::bit_cast<float>((*b)[kWords * (k / kWords) + 1]) << ")";
  return result;
}

// The same for each object, and that nothing is drawn that is none of theirs.
inline ::testing::AssertionResult areSameObjects(const client::KeyframeMesh& mesh,
                                                 const client::KeyframeMesh& expected) {
  const auto partOf = [](const client::KeyframeMesh& whole, size_t i) {
    const client::ObjectPart& part = whole.object_parts[i];
    client::BlendMesh object = whole.objects;
    object.indices.assign(whole.objects.indices.begin() + part.first_index,
                          whole.objects.indices.begin() + part.first_index + part.index_count);
    return object;
  };
  if (mesh.object_parts.size() != expected.object_parts.size()) return ::testing::AssertionFailure() << "other objects";
  for (size_t i = 0; i < mesh.object_parts.size(); ++i) {
    if (mesh.object_parts[i].model != expected.object_parts[i].model)
      return ::testing::AssertionFailure() << "object " << i << " has another model";
    if (auto same = isSameMesh(partOf(mesh, i), partOf(expected, i)); !same) return same << ", object " << i;
  }
  return isSameMesh(mesh.objects, expected.objects);
}

}  // namespace foreland::test
