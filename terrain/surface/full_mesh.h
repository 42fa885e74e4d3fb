// The surface at full resolution, flat: every vertex, every triangle and which triangles meet at a vertex. Bounds are
// computed over it. Vertices are numbered base vertices first, then nodes by slot. Immutable; the surface must outlive
// it; any thread. Cost: about 100 bytes a vertex.
#pragma once

#include <array>
#include <cstdint>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

#include "terrain/surface/surface.h"

namespace foreland::terrain {

class FullMesh {
 public:
  explicit FullMesh(const TrueSurface& surface);

  size_t vertex(proto::NodeId v) const {
    return topology_.isBase(v) ? proto::baseVertexOf(v) : topology_.baseVertexCount() + size_t{topology_.slot(v)};
  }
  size_t vertexCount() const { return positions_.size(); }
  const glm::dvec3& position(size_t vertex) const { return positions_[vertex]; }
  std::span<const std::array<uint32_t, 3>> triangles() const { return triangles_; }
  // Unit normals, outward; zero for triangles without an area.
  const glm::dvec3& normal(uint32_t triangle) const { return normals_[triangle]; }
  std::span<const uint32_t> trianglesAt(size_t vertex) const {
    return std::span(triangles_at_).subspan(first_at_[vertex], first_at_[vertex + 1] - first_at_[vertex]);
  }
  // The mean of the normals around, weighted by area; (0, 0, 1) if there is none.
  glm::dvec3 normalAt(size_t vertex) const;

 private:
  const proto::MeshTopology& topology_;
  std::vector<glm::dvec3> positions_;
  std::vector<std::array<uint32_t, 3>> triangles_;
  std::vector<glm::dvec3> normals_;
  std::vector<uint32_t> first_at_, triangles_at_;
};

}  // namespace foreland::terrain
