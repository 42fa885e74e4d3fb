#include "terrain/surface/full_mesh.h"

#include <glm/geometric.hpp>

#include "proto/topology/mesh_triangles.h"

namespace foreland::terrain {

FullMesh::FullMesh(const TrueSurface& surface) : topology_(surface.topology) {
  for (const glm::ivec3& p : surface.base) positions_.push_back(glm::dvec3(p) * surface.quantum_m);
  for (const glm::ivec3& p : surface.nodes) positions_.push_back(glm::dvec3(p) * surface.quantum_m);
  first_at_.assign(positions_.size() + 1, 0);
  const auto everywhere = [](proto::NodeId) { return true; };
  proto::forEachTriangle(topology_, everywhere, [&](proto::NodeId a, proto::NodeId b, proto::NodeId c) {
    const std::array<uint32_t, 3> t{static_cast<uint32_t>(vertex(a)), static_cast<uint32_t>(vertex(b)),
                                    static_cast<uint32_t>(vertex(c))};
    triangles_.push_back(t);
    for (uint32_t v : t) ++first_at_[v + 1];
    const glm::dvec3 n = glm::cross(positions_[t[1]] - positions_[t[0]], positions_[t[2]] - positions_[t[0]]);
    const double length = glm::length(n);
    normals_.push_back(length > 0 ? n / length : glm::dvec3(0));
  });
  for (size_t v = 0; v < positions_.size(); ++v) first_at_[v + 1] += first_at_[v];
  triangles_at_.resize(first_at_.back());
  std::vector<uint32_t> next(first_at_.begin(), first_at_.end() - 1);
  for (uint32_t t = 0; t < triangles_.size(); ++t)
    for (uint32_t v : triangles_[t]) triangles_at_[next[v]++] = t;
}

glm::dvec3 FullMesh::normalAt(size_t vertex) const {
  glm::dvec3 sum(0);
  for (uint32_t t : trianglesAt(vertex)) {
    const auto& [a, b, c] = triangles_[t];
    sum += glm::cross(positions_[b] - positions_[a], positions_[c] - positions_[a]);
  }
  const double length = glm::length(sum);
  return length > 0 ? sum / length : glm::dvec3(0, 0, 1);
}

}  // namespace foreland::terrain
