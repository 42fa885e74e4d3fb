// What inner solids must keep out of: everything that may be drawn of a surface, in groups of near triangles. Each
// group is known by how far it reaches in each of the directions that solids' planes may have. Immutable; any thread.
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

#include "terrain/surface/inner_solids.h"

namespace foreland::terrain {

class Obstacles {
 public:
  // O(directions times vertices).
  Obstacles(const TrueSurface& surface, const FullMesh& mesh, const std::vector<glm::dvec3>& directions);

  // No coordinate of what is drawn is larger.
  double reach() const { return reach_m_; }
  // Planes of the directions `set` with the point inside, such that each obstacle lies outside of one. Empty if an
  // obstacle is on both sides of the point in every direction. O(n log n) for n obstacles.
  std::vector<SolidPlane> grow(const glm::dvec3& point, std::span<const uint32_t> set) const;

 private:
  double extent(uint32_t direction, size_t obstacle) const { return extents_[direction][obstacle]; }
  std::vector<double> offsetsAbout(const glm::dvec3& point, std::span<const uint32_t> set) const;
  void moveOut(std::span<const uint32_t> set, std::vector<double>& offsets) const;

  std::vector<glm::dvec3> directions_;
  std::vector<std::vector<double>> extents_;  // by direction, by obstacle: the offset of a plane that keeps it out
  size_t count_ = 0;
  double reach_m_ = 0;
};

}  // namespace foreland::terrain
