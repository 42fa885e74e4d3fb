// The lowest ground of each cell of a lattice in a plane, of triangles that are given one by one. One owner.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <limits>
#include <vector>

namespace foreland::server {

class LowestCells {
 public:
  using Corners = std::array<glm::dvec3, 3>;

  // Cell (0, 0) begins at `low_m`.
  LowestCells(const glm::dvec2& low_m, double spacing_m, uint32_t columns, uint32_t rows)
      : low_m_(low_m),
        spacing_m_(spacing_m),
        columns_(columns),
        rows_(rows),
        lowest_(size_t{columns} * rows, std::numeric_limits<float>::infinity()) {}
  double spacing() const { return spacing_m_; }
  uint32_t columns() const { return columns_; }
  uint32_t rows() const { return rows_; }

  // Whatever lies within so many metres of a triangle: within its corners, and above its plane.
  void include(const Corners& corners, double widened_m = 0) {
    const glm::dvec3 low = glm::min(glm::min(corners[0], corners[1]), corners[2]) - widened_m,
                     high = glm::max(glm::max(corners[0], corners[1]), corners[2]) + widened_m;
    const glm::dvec3 normal = glm::cross(corners[1] - corners[0], corners[2] - corners[0]);
    const double length = glm::length(normal);
    if (std::fabs(normal.z) < 1e-3 * length) return include(low, high);  // too steep
    const glm::dvec2 rise = -glm::dvec2(normal) / normal.z;
    const double within =
        0.5 * spacing_m_ * (std::fabs(rise.x) + std::fabs(rise.y)) + widened_m * length / std::fabs(normal.z);
    forEachCell(low, high, [&](const glm::dvec2& middle) {
      return std::max(low.z, corners[0].z + glm::dot(rise, middle - glm::dvec2(corners[0])) - within);
    });
  }
  // Within a box.
  void include(const glm::dvec3& low, const glm::dvec3& high) {
    forEachCell(low, high, [&](const glm::dvec2&) { return low.z; });
  }

  // Of the four cells about a vertex of the lattice, or those of them that are there.
  float lowestAbout(uint32_t i, uint32_t j) const {
    float lowest = std::numeric_limits<float>::infinity();
    for (uint32_t y = std::max(j, 1u) - 1; y <= std::min(j, rows_ - 1); ++y)
      for (uint32_t x = std::max(i, 1u) - 1; x <= std::min(i, columns_ - 1); ++x) lowest = std::min(lowest, of(x, y));
    return lowest;
  }
  float of(uint32_t i, uint32_t j) const {
    constexpr float kNothing_m = -1e6f;  // where there is no ground
    const float lowest = lowest_[size_t{j} * columns_ + i];
    return std::isinf(lowest) ? kNothing_m : lowest;
  }

 private:
  // That the box from `low` to `high` may lie over; `boundOver` takes the middle of a cell.
  template <class Bound>
  void forEachCell(const glm::dvec3& low, const glm::dvec3& high, const Bound& boundOver) {
    const glm::dvec2 first = glm::floor((glm::dvec2(low) - low_m_) / spacing_m_),
                     last = glm::floor((glm::dvec2(high) - low_m_) / spacing_m_);
    if (last.x < 0 || last.y < 0 || first.x >= columns_ || first.y >= rows_) return;
    const glm::uvec2 begin(glm::max(first, glm::dvec2(0))), end(glm::min(last, glm::dvec2(columns_ - 1, rows_ - 1)));
    for (uint32_t j = begin.y; j <= end.y; ++j)
      for (uint32_t i = begin.x; i <= end.x; ++i) {
        const glm::dvec2 middle = low_m_ + (glm::dvec2(i, j) + 0.5) * spacing_m_;
        float& lowest = lowest_[size_t{j} * columns_ + i];
        lowest = std::min(lowest, static_cast<float>(boundOver(middle)));
      }
  }

  glm::dvec2 low_m_;
  double spacing_m_;
  uint32_t columns_, rows_;
  std::vector<float> lowest_;
};

}  // namespace foreland::server
