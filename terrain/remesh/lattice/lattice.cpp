#include "terrain/remesh/lattice/lattice.h"

#include <algorithm>
#include <cmath>

#include "base/check.h"
#include "terrain/remesh/original/surface_point.h"

namespace foreland::terrain {

Lattice::Lattice(const std::vector<Triangle>& base_faces, uint32_t base_vertices, int levels)
    : side_(1u << levels), base_vertices_(base_vertices), faces_(base_faces), edges_of_(base_faces.size()) {
  CHECK_LE(levels, kMaxLevels);
  const std::vector<Triangle> twins = findAdjacency(faces_).twins;
  for (uint32_t f = 0; f < faces_.size(); ++f)
    for (uint32_t k = 0; k < 3; ++k) {
      const uint32_t twin = twins[f][k];
      if (twin != kNoIndex && twin / 3 < f) {
        edges_of_[f][k] = edges_of_[twin / 3][twin % 3] ^ 1;
        continue;
      }
      edges_of_[f][k] = static_cast<uint32_t>(2 * edges_.size());
      edges_.push_back({faces_[f][k], faces_[f][(k + 1) % 3], twin == kNoIndex});
    }
  const uint64_t count = countVertices(base_vertices, edges_.size(), faces_.size(), levels);
  CHECK_LT(count, static_cast<uint64_t>(kNoIndex));
  vertex_count_ = static_cast<uint32_t>(count);
}

uint64_t Lattice::countVertices(uint64_t base_vertices, uint64_t base_edges, uint64_t base_faces, int levels) {
  const uint64_t side = 1ull << levels;
  return base_vertices + base_edges * (side - 1) + base_faces * (side - 1) * (side > 1 ? side - 2 : 0) / 2;
}

uint32_t Lattice::edgeVertex(uint32_t e, uint32_t i) const {
  if (i == 0) return edges_[e].from;
  if (i == side_) return edges_[e].to;
  return base_vertices_ + e * (side_ - 1) + i - 1;
}

uint32_t Lattice::vertex(uint32_t face, uint32_t i, uint32_t j) const {
  const uint32_t n = side_, k = n - i - j;
  const auto onEdge = [&](uint32_t edge, uint32_t offset) {
    const uint32_t e = edges_of_[face][edge];
    return edgeVertex(e / 2, e % 2 ? n - offset : offset);
  };
  if (j == 0) return onEdge(0, i);
  if (k == 0) return onEdge(1, j);
  if (i == 0) return onEdge(2, k);
  const uint32_t inner = (n - 1) * (n - 2) / 2;
  // Inner rows are j = 1, 2, ...; row j has the n - 1 - j vertices i = 1, 2, ...
  const uint32_t before = (j - 1) * (n - 2) - (j - 1) * (j - 2) / 2;
  return base_vertices_ + edgeCount() * (n - 1) + face * inner + before + i - 1;
}

Triangle Lattice::triangle(uint32_t face, uint32_t t) const {
  // Rows are counted from corner 2; a row has 2 * row + 1 triangles, upright ones first.
  const auto row = static_cast<uint32_t>(std::sqrt(static_cast<double>(t)));
  const uint32_t j = side_ - 1 - row, in_row = t - row * row;
  if (in_row <= row) return {vertex(face, in_row, j), vertex(face, in_row + 1, j), vertex(face, in_row, j + 1)};
  const uint32_t i = in_row - row - 1;
  return {vertex(face, i + 1, j), vertex(face, i + 1, j + 1), vertex(face, i, j + 1)};
}

std::vector<Triangle> Lattice::triangles() const {
  std::vector<Triangle> all;
  all.reserve(triangleCount());
  for (uint32_t f = 0; f < faces_.size(); ++f)
    for (uint32_t t = 0; t < side_ * side_; ++t) all.push_back(triangle(f, t));
  return all;
}

LatticeCell Lattice::cellAt(uint32_t face, const glm::dvec3& weights) const {
  const uint32_t n = side_;
  const double x = weights.y * n, y = weights.z * n;
  const auto i = static_cast<uint32_t>(std::min(std::floor(x), n - 1.0));
  const uint32_t j = std::min(static_cast<uint32_t>(y), n - 1 - i);
  const double u = x - i, v = y - j;
  if (u + v <= 1 || i + j == n - 1)
    return {{vertex(face, i, j), vertex(face, i + 1, j), vertex(face, i, j + 1)}, cleanWeights({1 - u - v, u, v})};
  return {{vertex(face, i + 1, j), vertex(face, i + 1, j + 1), vertex(face, i, j + 1)},
          cleanWeights({1 - v, u + v - 1, 1 - u})};
}

}  // namespace foreland::terrain
