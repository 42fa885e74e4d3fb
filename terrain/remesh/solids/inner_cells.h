// A coarse lattice of cubes over a closed surface: which middles are inside, and how deep. For choosing where to look
// for solids, not for proofs. One owner.
#pragma once

#include <array>
#include <cstdint>
#include <glm/vec3.hpp>
#include <optional>
#include <vector>

#include "terrain/surface/full_mesh.h"
#include "terrain/surface/inner_solids.h"

namespace foreland::terrain {

class InnerCells {
 public:
  // Cost: O(triangles, and the columns of cells that they are over).
  explicit InnerCells(const FullMesh& mesh);

  size_t count() const { return depth_.size(); }
  size_t innerCount() const { return inner_count_; }
  double diagonal() const { return diagonal_; }  // of the surface's box
  glm::dvec3 middle(uint32_t cell) const;
  // The cell that most layers of inner cells lie around, of those that are not taken; the first of equals.
  std::optional<uint32_t> deepestLeft() const;
  void take(uint32_t cell) { is_taken_[cell] = true; }
  // Those whose middles the solid holds.
  std::vector<uint32_t> inside(const ConvexSolid& solid) const;

 private:
  void markInside(const FullMesh& mesh);
  void measureDepths();
  uint32_t at(uint32_t x, uint32_t y, uint32_t z) const { return (z * size_[1] + y) * size_[0] + x; }

  glm::dvec3 low_{0};
  double side_ = 0, diagonal_ = 0;
  std::array<uint32_t, 3> size_{};
  std::vector<uint16_t> depth_;  // 0: not inside
  std::vector<bool> is_taken_;
  size_t inner_count_ = 0;
};

}  // namespace foreland::terrain
