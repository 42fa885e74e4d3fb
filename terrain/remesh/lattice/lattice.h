// The full-resolution mesh over a base: each base face cut by quadrisection into 4^levels triangles, its vertices on a
// lattice of 2^levels intervals a side, those on base edges shared. Immutable; any thread; every function is O(1).
#pragma once

#include <array>
#include <cstdint>
#include <glm/vec3.hpp>
#include <vector>

#include "terrain/remesh/original/original.h"

namespace foreland::terrain {

// The triangle of the lattice that holds a place, and the weights of its corners.
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
  // `step` intervals from the edge's start.
  uint32_t edgeVertex(uint32_t e, uint32_t step) const;
  // Triangle number `t` of the side()^2 of a face, turned as the face is.
  Triangle triangle(uint32_t face, uint32_t t) const;
  std::vector<Triangle> triangles() const;  // all, face after face
  // That holds the point at `weights` of a face's corners.
  LatticeCell cellAt(uint32_t face, const glm::dvec3& weights) const;

 private:
  uint32_t side_, base_vertices_, vertex_count_;
  std::vector<Triangle> faces_;
  std::vector<Edge> edges_;
  std::vector<Triangle> edges_of_;  // of each face: 2 * edge + 1 if it runs against the edge
};

}  // namespace foreland::terrain
