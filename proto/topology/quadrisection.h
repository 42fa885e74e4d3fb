// Node arithmetic of the 4-to-1 split over a triangle base mesh (S 3.2, 3.4). Patches are the base faces; a vertex
// (x, y) of a patch has the barycentric coordinates (N - x - y, x, y) / N. With s = 2^t the largest power of two
// dividing both, a node's level is k - t, and it is the midpoint of an edge of 2s along the one of the three directions
// in which (x, y, N - x - y) / s is even.
//
//   support   the two triangles of 2s beside the edge, without their far corners: the hexagon of s around the node
//   children  the middles of the hexagon's six spokes: at most six, four on the border
//   parents   its edge's ends that are one level coarser: two inside a triangle of 4s, one on a side of it
//
// A node on a base edge belongs to the face with the lower number. Each level has one slot for each edge of each
// face, counted by the upright triangles that they belong to; the slots of edges that another face owns are padding.
//
// A view of a base mesh, which must outlive it; any thread; every function is O(1).
#pragma once

#include <array>
#include <cstdint>

#include "base/check.h"
#include "proto/topology/base_mesh.h"
#include "proto/topology/patch_point.h"

namespace foreland::proto {

class Quadrisection {
 public:
  static constexpr uint32_t kMaxLog2 = 15;

  Quadrisection(const BaseMesh& mesh, uint32_t log2) : mesh_(mesh), log2_(log2), size_(1 << log2) {}

  int maxLevel() const { return static_cast<int>(log2_); }
  uint64_t slotsOfLevel(int level) const { return uint64_t{mesh_.faceCount()} * slotsOfFace(rows(level)); }
  int level(const PatchPoint& p) const { return static_cast<int>(log2_ - p.scaleLog2()); }

  // The name of a lattice point of a patch, base vertices included.
  NodeId name(const PatchPoint& p) const {
    const uint32_t side = sideOf(p);
    if (side == kInside) return patchNodeId(p);
    const int32_t r = along(p, side);
    const HalfEdge h = 3 * p.patch + side, twin = mesh_.twin(h);
    if (r == 0) return baseVertexId(mesh_.vertex(h));
    return twin < h ? patchNodeId(onSide(twin, size_ - r)) : patchNodeId(p);
  }
  bool isInPatch(const PatchPoint& p) const { return p.x >= 0 && p.y >= 0 && p.x + p.y <= size_; }
  // A node's positions on the faces that hold it: on its own face first, then on the neighbour if it is on a base edge.
  PatchPoints appearances(const PatchPoint& n) const {
    PatchPoints result;
    result.push(n);
    const uint32_t side = sideOf(n);
    const HalfEdge twin = side == kInside ? kNoHalfEdge : mesh_.twin(3 * n.patch + side);
    if (twin != kNoHalfEdge) result.push(onSide(twin, size_ - along(n, side)));
    return result;
  }
  // True for the names of nodes, false for all other bits.
  bool isNode(const PatchPoint& p) const {
    return p.patch < mesh_.faceCount() && isInPatch(p) && name(p) == patchNodeId(p);
  }

  std::array<NodeId, 2> endpoints(const PatchPoint& n) const {
    const PatchPoint d = direction(n);
    return {name(n.moved(-d.x, -d.y)), name(n.moved(d.x, d.y))};
  }
  NodeList<2> parents(const PatchPoint& n) const {
    NodeList<2> result;
    const int coarser = level(n) - 1;
    for (NodeId end : endpoints(n))
      if (!isBaseVertexId(end) && level(patchPointOf(end)) == coarser) result.push(end);
    return result;
  }
  NodeList<6> children(const PatchPoint& n) const {
    const uint32_t t = n.scaleLog2();
    return t == 0 ? NodeList<6>{} : ring(n, 1 << (t - 1));
  }
  // The middles of the other sides of the one or two triangles beside the node's edge. If one of them or the node
  // itself is in the section, the triangle is split, and the node is a vertex of the mesh (S 3.6).
  NodeList<4> siblings(const PatchPoint& n) const {
    NodeList<4> result;
    for (NodeId v : ring(n, 1 << n.scaleLog2()))
      if (!isBaseVertexId(v) && level(patchPointOf(v)) == level(n)) result.push(v);
    return result;
  }

  uint64_t slotInLevel(const PatchPoint& n) const {
    const uint32_t t = n.scaleLog2(), m = rows(level(n));
    const uint32_t odd_x = static_cast<uint32_t>(n.x) >> t & 1, odd_y = static_cast<uint32_t>(n.y) >> t & 1;
    const uint32_t row = static_cast<uint32_t>(n.y) >> (t + 1), column = static_cast<uint32_t>(n.x) >> (t + 1);
    return uint64_t{n.patch} * slotsOfFace(m) + 3 * folded(row, column, m) + (odd_x & odd_y ? 2 : odd_y);
  }
  // The node of a slot, or NodeId{} if the slot is padding.
  NodeId nodeOfSlot(int level, uint32_t within) const {
    const uint32_t m = rows(level), in_face = within % slotsOfFace(m), cell = in_face / 3, kind = in_face % 3;
    uint32_t row = cell / (m + 1), column = cell % (m + 1);
    if (column >= m - row) column -= m - row, row = m - 1 - row;
    const uint32_t t = log2_ - static_cast<uint32_t>(level);
    const uint32_t x = 2 * column + (kind != 1 ? 1 : 0), y = 2 * row + (kind != 0 ? 1 : 0);
    const PatchPoint p{within / slotsOfFace(m), static_cast<int32_t>(x << t), static_cast<int32_t>(y << t)};
    return name(p) == patchNodeId(p) ? patchNodeId(p) : NodeId{};
  }

  FacePoint facePoint(const PatchPoint& p) const {
    return {p.patch,
            {static_cast<uint32_t>(size_ - p.x - p.y), static_cast<uint32_t>(p.x), static_cast<uint32_t>(p.y)}};
  }
  // The same point in another face, on whose side it lies.
  FacePoint facePointIn(uint32_t face, const PatchPoint& p) const {
    if (p.patch == face) return facePoint(p);
    const uint32_t side = sideOf(p);
    CHECK_NE(side, kInside);
    const HalfEdge twin = mesh_.twin(3 * p.patch + side);
    CHECK_EQ(BaseMesh::face(twin), face);
    return facePoint(onSide(twin, size_ - along(p, side)));
  }

 private:
  static constexpr uint32_t kInside = 3;

  // Upright triangles along a side, of which the level's nodes are the sides.
  static uint32_t rows(int level) { return 1u << (level - 1); }
  static uint32_t slotsOfFace(uint32_t m) { return 3 * (m * (m + 1) / 2); }
  // Rows of m, m - 1, ... 1 triangles, the last put after the first and so on: rows of m + 1.
  static uint32_t folded(uint32_t row, uint32_t column, uint32_t m) {
    return row < (m + 1) / 2 ? row * (m + 1) + column : (m - 1 - row) * (m + 1) + row + 1 + column;
  }

  uint32_t sideOf(const PatchPoint& p) const {
    if (p.y == 0) return p.x == size_ ? 1 : 0;
    return p.x == 0 ? 2 : p.x + p.y == size_ ? 1 : kInside;
  }
  int32_t along(const PatchPoint& p, uint32_t side) const { return side == 0 ? p.x : side == 1 ? p.y : size_ - p.y; }
  PatchPoint onSide(HalfEdge h, int32_t r) const {
    const uint32_t side = h % 3;
    return {h / 3, side == 0 ? r : side == 1 ? size_ - r : 0, side == 0 ? 0 : side == 1 ? r : size_ - r};
  }
  // From a node to an end of its edge.
  static PatchPoint direction(const PatchPoint& n) {
    const uint32_t t = n.scaleLog2();
    const bool odd_x = n.x >> t & 1, odd_y = n.y >> t & 1;
    return {n.patch, odd_x ? 1 << t : 0, odd_y ? (odd_x ? -1 : 1) * (1 << t) : 0};
  }

  // The points `step` around a node, those beyond its base edge included. `step` is at most the node's scale.
  NodeList<6> ring(const PatchPoint& n, int32_t step) const {
    NodeList<6> result;
    around(n, step, kInside, result);
    const PatchPoints points = appearances(n);
    if (points.count > 1) around(points.at[1], step, sideOf(points.at[1]), result);
    return result;
  }
  // The points `step` around `n` that are in its patch, but not on the side `without`.
  void around(const PatchPoint& n, int32_t step, uint32_t without, NodeList<6>& result) const {
    const int32_t offsets[6][2] = {{step, 0}, {0, step}, {-step, step}, {-step, 0}, {0, -step}, {step, -step}};
    for (const auto& [dx, dy] : offsets) {
      const PatchPoint p = n.moved(dx, dy);
      if (isInPatch(p) && !isOnSide(p, without)) result.push(name(p));
    }
  }
  bool isOnSide(const PatchPoint& p, uint32_t side) const {
    return (side == 0 && p.y == 0) || (side == 1 && p.x + p.y == size_) || (side == 2 && p.x == 0);
  }

  const BaseMesh& mesh_;
  uint32_t log2_;
  int32_t size_;
};

}  // namespace foreland::proto
