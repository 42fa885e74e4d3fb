#include "terrain/compare/closest.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <numeric>

#include "base/check.h"

namespace foreland::terrain {

namespace {

using glm::dvec3;

constexpr uint32_t kLeafFaces = 4;
constexpr int kDeepest = 64;  // of the tree: it halves, and faces are fewer than 2^32

double squaredDistanceToBox(const dvec3& p, const dvec3& low, const dvec3& high) {
  const dvec3 outside = glm::max(glm::max(low - p, p - high), dvec3(0));
  return glm::dot(outside, outside);
}

}  // namespace

dvec3 closestInTriangle(const dvec3& p, const dvec3& a, const dvec3& b, const dvec3& c) {
  const dvec3 ab = b - a, ac = c - a, ap = p - a, bp = p - b, cp = p - c;
  const double d1 = glm::dot(ab, ap), d2 = glm::dot(ac, ap);
  if (d1 <= 0 && d2 <= 0) return {1, 0, 0};
  const double d3 = glm::dot(ab, bp), d4 = glm::dot(ac, bp);
  if (d3 >= 0 && d4 <= d3) return {0, 1, 0};
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0 && d1 >= 0 && d3 <= 0) {
    const double t = d1 / (d1 - d3);
    return {1 - t, t, 0};
  }
  const double d5 = glm::dot(ab, cp), d6 = glm::dot(ac, cp);
  if (d6 >= 0 && d5 <= d6) return {0, 0, 1};
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0 && d2 >= 0 && d6 <= 0) {
    const double t = d2 / (d2 - d6);
    return {1 - t, 0, t};
  }
  const double va = d3 * d6 - d5 * d4;
  if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0) {
    const double t = (d4 - d3) / ((d4 - d3) + (d5 - d6));
    return {0, 1 - t, t};
  }
  const double all = va + vb + vc;
  return {va / all, vb / all, vc / all};
}

ClosestPoint::ClosestPoint(MeshView mesh) : mesh_(mesh), order_(mesh.faces.size()) {
  CHECK_TRUE(!mesh.faces.empty());
  std::iota(order_.begin(), order_.end(), 0);
  centres_.reserve(mesh.faces.size());
  for (const auto& t : mesh.faces)
    centres_.push_back((mesh.positions[t[0]] + mesh.positions[t[1]] + mesh.positions[t[2]]) / 3.0);
  nodes_.reserve(mesh.faces.size());
  nodes_.emplace_back();
  build(0, 0, static_cast<uint32_t>(order_.size()));
  centres_ = {};
}

void ClosestPoint::build(uint32_t node, uint32_t begin, uint32_t end) {
  dvec3 low(INFINITY), high(-INFINITY), centre_low(INFINITY), centre_high(-INFINITY);
  for (uint32_t i = begin; i < end; ++i) {
    for (uint32_t v : mesh_.faces[order_[i]])
      low = glm::min(low, mesh_.positions[v]), high = glm::max(high, mesh_.positions[v]);
    centre_low = glm::min(centre_low, centres_[order_[i]]), centre_high = glm::max(centre_high, centres_[order_[i]]);
  }
  nodes_[node] = {low, high, begin, end - begin};
  if (end - begin <= kLeafFaces) return;
  const dvec3 extent = centre_high - centre_low;
  const int axis = extent.x >= extent.y && extent.x >= extent.z ? 0 : extent.y >= extent.z ? 1 : 2;
  const uint32_t middle = begin + (end - begin) / 2;
  const auto at = [&](uint32_t i) { return order_.begin() + static_cast<ptrdiff_t>(i); };
  std::nth_element(at(begin), at(middle), at(end), [&](uint32_t a, uint32_t b) {
    return std::pair(centres_[a][axis], a) < std::pair(centres_[b][axis], b);
  });
  const auto child = static_cast<uint32_t>(nodes_.size());
  nodes_.resize(nodes_.size() + 2);
  nodes_[node].begin = child, nodes_[node].count = 0;
  build(child, begin, middle);
  build(child + 1, middle, end);
}

template <bool kFacing>
PointOnMesh ClosestPoint::search(const dvec3& p, const dvec3& direction) const {
  PointOnMesh best{.distance = INFINITY};
  double best_squared = INFINITY;
  std::array<std::pair<double, uint32_t>, kDeepest> waiting;
  size_t depth = 0;
  waiting[depth++] = {0.0, 0};
  while (depth > 0) {
    const auto [nearest, number] = waiting[--depth];
    if (nearest >= best_squared) continue;
    const Node& node = nodes_[number];
    for (uint32_t i = node.begin; i < node.begin + node.count; ++i) {
      const auto& t = mesh_.faces[order_[i]];
      const dvec3 &a = mesh_.positions[t[0]], &b = mesh_.positions[t[1]], &c = mesh_.positions[t[2]];
      if (kFacing && glm::dot(glm::cross(b - a, c - a), direction) <= 0) continue;
      const dvec3 weights = closestInTriangle(p, a, b, c);
      const dvec3 away = weights.x * a + weights.y * b + weights.z * c - p;
      const double squared = glm::dot(away, away);
      if (squared < best_squared) best_squared = squared, best = {0, order_[i], weights};
    }
    if (node.count > 0) continue;
    std::array<std::pair<double, uint32_t>, 2> children;
    for (uint32_t k = 0; k < 2; ++k) {
      const Node& child = nodes_[node.begin + k];
      children[k] = {squaredDistanceToBox(p, child.low, child.high), node.begin + k};
    }
    if (children[0].first < children[1].first) std::swap(children[0], children[1]);
    for (const auto& child : children) waiting[depth++] = child;  // the nearer one on top
  }
  best.distance = std::sqrt(best_squared);
  return best;
}

PointOnMesh ClosestPoint::find(const dvec3& p) const { return search<false>(p, {}); }

PointOnMesh ClosestPoint::findFacing(const dvec3& p, const dvec3& direction) const {
  const PointOnMesh facing = search<true>(p, direction);
  return std::isfinite(facing.distance) ? facing : find(p);
}

dvec3 ClosestPoint::positionOf(const PointOnMesh& at) const {
  const auto& t = mesh_.faces[at.face];
  return at.weights.x * mesh_.positions[t[0]] + at.weights.y * mesh_.positions[t[1]] +
         at.weights.z * mesh_.positions[t[2]];
}

double ClosestPoint::distanceToFace(const dvec3& p, uint32_t face) const {
  const auto& t = mesh_.faces[face];
  const dvec3 w = closestInTriangle(p, mesh_.positions[t[0]], mesh_.positions[t[1]], mesh_.positions[t[2]]);
  return glm::distance(p, positionOf({0, face, w}));
}

}  // namespace foreland::terrain
