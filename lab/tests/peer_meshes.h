// Meshes for the tests of other makers' codecs, and ways to spoil them.
#pragma once

#include <array>
#include <cmath>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "base/rng.h"
#include "lab/wire/peers/peer_mesh.h"

namespace foreland::test {

// A grid of rough heights on integers, each square cut by a diagonal drawn by lot; vertices and triangles shuffled.
inline lab::PeerMesh roughGrid(uint32_t width, uint32_t height, Rng& rng) {
  std::vector<uint32_t> names(width * height);
  for (uint32_t i = 0; i < names.size(); ++i) names[i] = i;
  for (uint32_t i = static_cast<uint32_t>(names.size()) - 1; i > 0; --i) std::swap(names[i], names[rng.below(i + 1)]);
  lab::PeerMesh mesh;
  mesh.positions.resize(names.size());
  for (uint32_t y = 0; y < height; ++y)
    for (uint32_t x = 0; x < width; ++x)
      mesh.positions[names[y * width + x]] = {x, y, std::floor(rng.uniform(-500, 2000))};
  std::vector<std::array<uint32_t, 3>> triangles;
  for (uint32_t y = 0; y + 1 < height; ++y)
    for (uint32_t x = 0; x + 1 < width; ++x) {
      const uint32_t sw = names[y * width + x], se = names[y * width + x + 1], nw = names[(y + 1) * width + x],
                     ne = names[(y + 1) * width + x + 1];
      const bool rises = rng.below(2) == 0;
      triangles.push_back(rises ? std::array{sw, se, ne} : std::array{sw, se, nw});
      triangles.push_back(rises ? std::array{sw, ne, nw} : std::array{se, ne, nw});
    }
  for (size_t i = triangles.size() - 1; i > 0; --i) std::swap(triangles[i], triangles[rng.below(i + 1)]);
  for (const auto& t : triangles) mesh.indices.insert(mesh.indices.end(), t.begin(), t.end());
  return mesh;
}

struct Damage {
  std::string name;
  std::function<void(lab::PeerMesh&, const glm::dvec3& tolerance, Rng&)> apply;
};

// Where a triangle begins of whose corners each is of another triangle, too.
inline size_t spareTriangle(const lab::PeerMesh& mesh, Rng& rng) {
  std::vector<int> uses(mesh.positions.size());
  for (uint32_t v : mesh.indices) ++uses[v];
  for (;;) {
    const size_t i = 3 * rng.below(mesh.indices.size() / 3);
    if (uses[mesh.indices[i]] > 1 && uses[mesh.indices[i + 1]] > 1 && uses[mesh.indices[i + 2]] > 1) return i;
  }
}

// Moves a vertex by a whole number that the codec can tell from 0.
inline void moveVertex(lab::PeerMesh& mesh, int axis, const glm::dvec3& tolerance, Rng& rng) {
  const double away = std::ceil(2.5 * tolerance[axis] + 1e-9);
  double& value = mesh.positions[rng.below(mesh.positions.size())][axis];
  value += value > away ? -away : away;
}

// Each leaves a mesh that a codec takes, but another one.
inline std::vector<Damage> damages() {
  using lab::PeerMesh;
  const auto moved = [](int axis) {
    return [axis](PeerMesh& mesh, const glm::dvec3& tolerance, Rng& rng) { moveVertex(mesh, axis, tolerance, rng); };
  };
  const auto turn = [](PeerMesh& mesh, const glm::dvec3&, Rng& rng) {
    const size_t i = 3 * rng.below(mesh.indices.size() / 3);
    std::swap(mesh.indices[i], mesh.indices[i + 1]);
  };
  const auto leave_out = [](PeerMesh& mesh, const glm::dvec3&, Rng& rng) {
    const auto at = mesh.indices.begin() + static_cast<ptrdiff_t>(spareTriangle(mesh, rng));
    mesh.indices.erase(at, at + 3);
  };
  const auto replace = [](PeerMesh& mesh, const glm::dvec3&, Rng& rng) {
    const size_t to = spareTriangle(mesh, rng), from = to == 0 ? 3 : 0;
    for (size_t k = 0; k < 3; ++k) mesh.indices[to + k] = mesh.indices[from + k];
  };
  return {{"a vertex moved along x", moved(0)}, {"a vertex moved along y", moved(1)},
          {"a vertex moved along z", moved(2)}, {"a triangle turned round", turn},
          {"a triangle left out", leave_out},   {"a triangle sent twice", replace}};
}

}  // namespace foreland::test
