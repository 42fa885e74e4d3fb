#include "terrain/remesh/solids/obstacles.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <numeric>

namespace foreland::terrain {

namespace {

using glm::dvec3;

constexpr size_t kMaxObstacles = 1u << 16;
constexpr int kRounds = 4;  // in which planes move out; later ones gain nothing

}  // namespace

Obstacles::Obstacles(const TrueSurface& surface, const FullMesh& mesh, const std::vector<dvec3>& directions)
    : directions_(directions) {
  const DrawnExtents drawn(surface, mesh);
  reach_m_ = drawn.reach();
  // Triangles that follow one another lie near each other (proto/topology/mesh_triangles.h).
  const size_t each = (mesh.triangles().size() + kMaxObstacles - 1) / kMaxObstacles;
  count_ = (mesh.triangles().size() + each - 1) / each;
  std::vector<double> most;
  for (const dvec3& direction : directions) {
    drawn.along(direction, most);
    std::vector<double>& extents = extents_.emplace_back(count_, -INFINITY);
    for (size_t t = 0; t < mesh.triangles().size(); ++t)
      for (const uint32_t v : mesh.triangles()[t]) extents[t / each] = std::max(extents[t / each], most[v]);
    // Twice, so that the proof, which adds it once, has some to spare.
    for (double& extent : extents) extent += 2 * drawn.pad();
  }
}

std::vector<SolidPlane> Obstacles::grow(const dvec3& point, std::span<const uint32_t> set) const {
  std::vector<double> offsets = offsetsAbout(point, set);
  std::vector<SolidPlane> planes;
  for (size_t k = 0; k < offsets.size(); ++k)
    if (!(offsets[k] < glm::dot(directions_[set[k]], point))) return {};
  if (offsets.empty()) return {};
  moveOut(set, offsets);
  for (size_t k = 0; k < set.size(); ++k)
    if (std::isfinite(offsets[k])) planes.push_back({directions_[set[k]], offsets[k]});
  return planes;
}

std::vector<double> Obstacles::offsetsAbout(const dvec3& point, std::span<const uint32_t> set) const {
  std::vector<double> at(set.size()), offsets(set.size(), -INFINITY);
  for (size_t k = 0; k < set.size(); ++k) at[k] = glm::dot(directions_[set[k]], point);
  // The direction in which an obstacle may be kept out farthest from the point, and how far that is.
  std::vector<std::pair<double, uint32_t>> farthest(count_, {-INFINITY, 0});
  for (uint32_t k = 0; k < set.size(); ++k)
    for (size_t i = 0; i < count_; ++i) farthest[i] = std::max(farthest[i], {at[k] - extent(set[k], i), k});
  std::vector<uint32_t> order(count_);
  std::iota(order.begin(), order.end(), 0u);
  std::ranges::sort(order, {}, [&](uint32_t i) { return std::pair(farthest[i].first, i); });
  for (const uint32_t i : order) {
    const auto isOut = [&](uint32_t k) { return extent(set[k], i) <= offsets[k]; };
    bool is_out = false;
    for (uint32_t k = 0; k < set.size() && !is_out; ++k) is_out = isOut(k);
    if (!is_out) offsets[farthest[i].second] = extent(set[farthest[i].second], i);
  }
  return offsets;
}

void Obstacles::moveOut(std::span<const uint32_t> set, std::vector<double>& offsets) const {
  for (int round = 0; round < kRounds; ++round) {
    bool has_moved = false;
    for (size_t k = 0; k < set.size(); ++k) {
      double needed = -INFINITY;
      for (size_t i = 0; i < count_; ++i) {
        bool is_out = false;
        for (size_t other = 0; other < set.size() && !is_out; ++other)
          is_out = other != k && extent(set[other], i) <= offsets[other];
        if (!is_out) needed = std::max(needed, extent(set[k], i));
      }
      has_moved |= needed < offsets[k];
      offsets[k] = std::min(offsets[k], needed);
    }
    if (!has_moved) break;
  }
}

}  // namespace foreland::terrain
