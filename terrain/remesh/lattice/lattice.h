// The full-resolution mesh over a base mesh: each base face is split by quadrisection into 4^levels triangles. The
// vertices form a lattice of 2^levels intervals a side; faces share those on base edges. Immutable; any thread; every
// function is O(1).
#pragma once

#include <array>
#include <cstdint>
#include <glm/vec3.hpp>
#include <vector>

#include "terrain/remesh/original/original.h"

namespace foreland::terrain {

// A point of the lattice: a triangle that contains it, and barycentric weights of its corners.
struct LatticeCell {
  Triangle vertices{};
  glm::dvec3 weights{1, 0, 0};
};

class Lattice {
 public:
  static constexpr int kMaxLevels = 12;

  Lattice(const std::vector<Triangle>& base_faces, uint32_t base_vertices, int levels);

  uint32_t side() const { return side_; }  // intervals along a base edge
  uint32_t vertexCount() const { return vertex_count_; }
  uint64_t triangleCount() const { return static_cast<uint64_t>(faces_.size()) * side_ * side_; }
  uint32_t baseVertexCount() const { return base_vertices_; }
  uint32_t edgeCount() const { return static_cast<uint32_t>(edges_.size()); }
  static uint64_t countVertices(uint64_t base_vertices, uint64_t base_edges, uint64_t base_faces, int levels);

  struct Edge {
    uint32_t from = 0, to = 0;  // base vertices
    bool is_border = false;
  };
  const Edge& edge(uint32_t e) const { return edges_[e]; }

  // `i` intervals from the face's corner 0 towards corner 1, `j` towards corner 2; i + j <= side().
  uint32_t vertex(uint32_t face, uint32_t i, uint32_t j) const;
  // `i` intervals from the edge's start.
  uint32_t edgeVertex(uint32_t e, uint32_t i) const;
  // Triangle `t` of the side()^2 of a face, with the face's orientation.
  Triangle triangle(uint32_t face, uint32_t t) const;
  std::vector<Triangle> triangles() const;  // of all faces, one face after the other
  // The cell of the point at barycentric `weights` of a base face.
  LatticeCell cellAt(uint32_t face, const glm::dvec3& weights) const;

 private:
  uint32_t side_, base_vertices_, vertex_count_;
  std::vector<Triangle> faces_;
  std::vector<Edge> edges_;
  std::vector<Triangle> edges_of_;  // of each face: 2 * edge, plus 1 if the face traverses the edge backwards
};

}  // namespace foreland::terrain
