#include "terrain/remesh/solids/inner_cells.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

namespace foreland::terrain {

namespace {

using glm::dvec3;

constexpr uint32_t kCells = 40;          // along the longest side of the box
constexpr double kBeside = 0.000123457;  // of a cell: keeps columns off vertices and edges at round coordinates

}  // namespace

InnerCells::InnerCells(const FullMesh& mesh) {
  dvec3 low(INFINITY), high(-INFINITY);
  for (const auto& t : mesh.triangles())
    for (const uint32_t v : t) low = glm::min(low, mesh.position(v)), high = glm::max(high, mesh.position(v));
  const dvec3 box = high - low;
  diagonal_ = glm::length(box);
  side_ = std::max({box.x, box.y, box.z}) / kCells;
  if (!(side_ > 0)) return;
  low_ = low + side_ * kBeside * dvec3(1, 1.7, 2.3);
  for (int axis = 0; axis < 3; ++axis)
    size_[static_cast<size_t>(axis)] = std::max(1u, static_cast<uint32_t>(std::ceil(box[axis] / side_)));
  depth_.assign(size_t{size_[0]} * size_[1] * size_[2], 0);
  is_taken_.assign(depth_.size(), false);
  markInside(mesh);
  measureDepths();
}

dvec3 InnerCells::middle(uint32_t cell) const {
  const uint32_t x = cell % size_[0], y = cell / size_[0] % size_[1], z = cell / (size_[0] * size_[1]);
  return low_ + side_ * (dvec3(x, y, z) + 0.5);
}

// By how often the column through a middle leaves and enters the surface below it.
void InnerCells::markInside(const FullMesh& mesh) {
  std::vector<int> winding(depth_.size(), 0);
  for (const auto& t : mesh.triangles()) {
    const dvec3 a = (mesh.position(t[0]) - low_) / side_ - 0.5, b = (mesh.position(t[1]) - low_) / side_ - 0.5,
                c = (mesh.position(t[2]) - low_) / side_ - 0.5;
    const double area = (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
    if (area == 0) continue;
    const auto first = [](double least) { return static_cast<uint32_t>(std::max(0.0, std::ceil(least))); };
    const auto end = [](double most, uint32_t size) {
      return static_cast<uint32_t>(std::clamp(std::floor(most) + 1, 0.0, double(size)));
    };
    for (uint32_t y = first(std::min({a.y, b.y, c.y})); y < end(std::max({a.y, b.y, c.y}), size_[1]); ++y)
      for (uint32_t x = first(std::min({a.x, b.x, c.x})); x < end(std::max({a.x, b.x, c.x}), size_[0]); ++x) {
        const double u = ((b.x - x) * (c.y - y) - (b.y - y) * (c.x - x)) / area,
                     v = ((c.x - x) * (a.y - y) - (c.y - y) * (a.x - x)) / area, w = 1 - u - v;
        if (u < 0 || v < 0 || w < 0) continue;
        const double height = u * a.z + v * b.z + w * c.z;
        for (uint32_t z = 0; z < end(height, size_[2]); ++z) winding[at(x, y, z)] += area > 0 ? 1 : -1;
      }
  }
  for (size_t cell = 0; cell < depth_.size(); ++cell)
    if (winding[cell] == 1) depth_[cell] = 1, ++inner_count_;
}

// A layer at a time: a cell is one deeper than the least deep of those around it.
void InnerCells::measureDepths() {
  for (uint16_t depth = 1;; ++depth) {
    std::vector<uint32_t> deeper;
    for (uint32_t z = 1; z + 1 < size_[2]; ++z)
      for (uint32_t y = 1; y + 1 < size_[1]; ++y)
        for (uint32_t x = 1; x + 1 < size_[0]; ++x) {
          if (depth_[at(x, y, z)] != depth) continue;
          bool is_deeper = true;
          for (uint32_t i = 0; i < 27 && is_deeper; ++i)
            is_deeper = depth_[at(x + i % 3 - 1, y + i / 3 % 3 - 1, z + i / 9 - 1)] >= depth;
          if (is_deeper) deeper.push_back(at(x, y, z));
        }
    if (deeper.empty()) return;
    for (const uint32_t cell : deeper) depth_[cell] = static_cast<uint16_t>(depth + 1);
  }
}

std::optional<uint32_t> InnerCells::deepestLeft() const {
  std::optional<uint32_t> deepest;
  for (uint32_t cell = 0; cell < depth_.size(); ++cell)
    if (depth_[cell] > 0 && !is_taken_[cell] && (!deepest || depth_[cell] > depth_[*deepest])) deepest = cell;
  return deepest;
}

std::vector<uint32_t> InnerCells::inside(const ConvexSolid& solid) const {
  std::vector<uint32_t> cells;
  for (uint32_t cell = 0; cell < depth_.size(); ++cell) {
    const dvec3 p = middle(cell);
    if (depth_[cell] > 0 &&
        std::ranges::all_of(solid.planes(), [&](const SolidPlane& k) { return glm::dot(k.normal, p) >= k.offset; }))
      cells.push_back(cell);
  }
  return cells;
}

}  // namespace foreland::terrain
