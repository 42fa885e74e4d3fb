// Node arithmetic of Rivara bisection over a triangle base mesh (P 2.1). The centre of each face is inserted and the
// face's own edges are the refinement edges, which makes any base mesh compatible. The two root triangles at a base
// edge (a, b) make a square, its diagonal the edge: that is a patch. Its corners are a (0, 0), the centre on the right
// (N, 0), b (N, N) and the centre on the left (0, N), where a, b is how the edge's first half-edge runs. On the border
// only the left half is there, x <= y. In a square everything is as on a grid's root square (grid.h), one level later:
//
//   centre  x / s and y / s odd   of a square of 2s; level 2(k-1-t)+1; its edge is the diagonal through the centre of
//                                 the square of 4s around it, or the base edge; parents are the side nodes on the other
//   side    one of them odd       of a square of 2s; level 2(k-1-t)+2; parents are the centres beside it
//
// with s = 2^t the largest power of two that divides x and y. Squares meet along the segments from a base vertex to a
// centre, which belong to the square whose edge follows that vertex in the face: the sides x = 0 and x = N. So each
// square has as many side nodes as twice its cells, and, the border apart, slots have no padding. Cells of a level
// stand in Morton order.
//
// A view of a base mesh, which must outlive it; any thread; every function is O(1).
#pragma once

#include <array>
#include <cstdint>

#include "base/check.h"
#include "proto/topology/base_mesh.h"
#include "proto/topology/patch_point.h"

namespace foreland::proto {

class Bisection {
 public:
  static constexpr uint32_t kMaxLog2 = 15;

  Bisection(const BaseMesh& mesh, uint32_t log2) : mesh_(mesh), log2_(log2), size_(1 << log2) {}

  int maxLevel() const { return 2 * static_cast<int>(log2_); }
  uint64_t slotsOfLevel(int level) const {
    return uint64_t{mesh_.edgeCount()} << (2 * cellsLog2(level) + sides(level));
  }
  int level(const PatchPoint& p) const {
    const uint32_t t = p.scaleLog2();
    return 2 * static_cast<int>(log2_ - 1 - t) + (isCentre(p, t) ? 1 : 2);
  }

  // The name of a lattice point of a patch, base vertices and centres of faces included.
  NodeId name(const PatchPoint& p) const {
    const bool low = p.y == 0, high = p.y == size_;
    if (!low && !high) return patchNodeId(p);
    const HalfEdge h = low ? mesh_.twin(mesh_.first(p.patch)) : mesh_.first(p.patch);
    const int32_t r = low ? p.x : size_ - p.x;  // from the base vertex
    if (r == 0) return baseVertexId(mesh_.vertex(low ? mesh_.first(p.patch) : BaseMesh::next(h)));
    if (r == size_) return centreOf(BaseMesh::face(h));
    return patchNodeId(startOf(BaseMesh::next(h), r));
  }
  bool isInPatch(const PatchPoint& p) const {
    if (p.x < 0 || p.y < 0 || p.x > size_ || p.y > size_) return false;
    return p.x <= p.y || mesh_.twin(mesh_.first(p.patch)) != kNoHalfEdge;
  }
  // A node's positions on the squares that hold it: on its own square first, then on the neighbour if it is on a side.
  PatchPoints appearances(const PatchPoint& n) const {
    PatchPoints result;
    result.push(n);
    if (isOnSeam(n)) result.push(acrossSeam(n));
    return result;
  }
  bool isNode(const PatchPoint& p) const {
    return p.patch < mesh_.edgeCount() && isInPatch(p) && p.y > 0 && p.y < size_;
  }

  // From a node to an end of its edge, wherever it appears.
  std::array<int32_t, 2> halfEdgeAt(const PatchPoint& n) const {
    const uint32_t t = n.scaleLog2();
    const int32_t s = 1 << t;
    if (isCentre(n, t)) return {s, diagonalRises(n, t) ? s : -s};
    return n.y >> t & 1 ? std::array<int32_t, 2>{0, s} : std::array<int32_t, 2>{s, 0};
  }
  std::array<NodeId, 2> endpoints(const PatchPoint& n) const {
    const auto [dx, dy] = halfEdgeAt(n);
    return {name(n.moved(-dx, -dy)), name(n.moved(dx, dy))};
  }
  NodeList<2> parents(const PatchPoint& n) const {
    const uint32_t t = n.scaleLog2();
    const int32_t s = 1 << t;
    NodeList<2> result;
    if (isCentre(n, t)) {
      if (t + 1 == log2_) return result;
      const int32_t fall = diagonalRises(n, t) ? s : -s;
      pushInside(n.moved(-s, fall), result);
      pushInside(n.moved(s, -fall), result);
    } else {
      for (const PatchPoint& p : appearances(n)) {
        const bool upright = p.y >> t & 1;
        pushInside(upright ? p.moved(-s, 0) : p.moved(0, -s), result);
        pushInside(upright ? p.moved(s, 0) : p.moved(0, s), result);
      }
    }
    return result;
  }
  NodeList<6> children(const PatchPoint& n) const {
    const uint32_t t = n.scaleLog2();
    const int32_t s = 1 << t, h = s >> 1;
    NodeList<6> result;
    if (isCentre(n, t)) {
      for (const auto& [dx, dy] : {std::array{-s, 0}, {s, 0}, {0, -s}, {0, s}}) pushInside(n.moved(dx, dy), result);
    } else if (t > 0) {
      for (const PatchPoint& p : appearances(n)) pushDiagonals(p, h, result);
    }
    return result;
  }

  uint64_t slotInLevel(const PatchPoint& n) const {
    const uint32_t t = n.scaleLog2(), m = log2_ - 1 - t;
    const uint32_t x = static_cast<uint32_t>(n.x) >> (t + 1), y = static_cast<uint32_t>(n.y) >> (t + 1);
    const uint64_t patch = uint64_t{n.patch} << (2 * m);
    if (isCentre(n, t)) return patch + morton(x, y);
    if (n.x == size_) return 2 * (patch + morton(y, 0)) + 1;  // instead of the lower side, which another square owns
    return 2 * (patch + morton(x, y)) + (n.y >> t & 1 ? 0 : 1);
  }
  // The node of a slot, or NodeId{} if the slot is padding.
  NodeId nodeOfSlot(int level, uint32_t within) const {
    const uint32_t m = cellsLog2(level), t = log2_ - 1 - m, cell = within >> sides(level);
    uint32_t x = unspread(cell & ((1u << (2 * m)) - 1)), y = unspread((cell & ((1u << (2 * m)) - 1)) >> 1);
    const uint32_t patch = cell >> (2 * m);
    x *= 2, y *= 2;
    if (!sides(level)) {
      ++x, ++y;
    } else if (!(within & 1)) {
      ++y;
    } else if (y > 0) {
      ++x;
    } else {
      y = x + 1, x = 2u << m;
    }
    const PatchPoint p{patch, static_cast<int32_t>(x << t), static_cast<int32_t>(y << t)};
    return isInPatch(p) ? patchNodeId(p) : NodeId{};
  }

  // In the half x <= y the point a (1 - y/N) + b x/N + centre (y - x)/N; the other half is that one turned by 180
  // degrees.
  FacePoint facePoint(const PatchPoint& p) const {
    const HalfEdge first = mesh_.first(p.patch);
    return p.x <= p.y ? facePointInHalf(first, p.x, p.y) : facePointInHalf(mesh_.twin(first), size_ - p.x, size_ - p.y);
  }
  // The same point in another face, on whose side it lies.
  FacePoint facePointIn(uint32_t face, const PatchPoint& p) const {
    const FacePoint own = facePoint(p);
    if (own.face == face) return own;
    CHECK_EQ(p.x, p.y);
    const HalfEdge twin = mesh_.twin(mesh_.first(p.patch));
    CHECK_EQ(BaseMesh::face(twin), face);
    return facePointInHalf(twin, size_ - p.x, size_ - p.y);
  }

 private:
  static bool isCentre(const PatchPoint& n, uint32_t t) { return n.x >> t & n.y >> t & 1; }
  static bool diagonalRises(const PatchPoint& n, uint32_t t) { return !((n.x ^ n.y) >> (t + 1) & 1); }
  static uint32_t sides(int level) { return level & 1 ? 0 : 1; }
  static uint32_t cellsLog2(int level) { return static_cast<uint32_t>(level - 1) / 2; }

  NodeId centreOf(uint32_t face) const { return baseVertexId(mesh_.vertexCount() + face); }
  template <class List>
  void pushInside(const PatchPoint& p, List& result) const {
    if (isInPatch(p)) result.push(name(p));
  }
  void pushDiagonals(const PatchPoint& n, int32_t h, NodeList<6>& result) const {
    for (const auto& [dx, dy] : {std::array{-h, -h}, {h, -h}, {-h, h}, {h, h}}) pushInside(n.moved(dx, dy), result);
  }

  bool isOnSeam(const PatchPoint& n) const { return n.x == 0 || n.x == size_; }
  // The point at distance r from the start of `h` towards the centre of its face, on the square of `h`.
  PatchPoint startOf(HalfEdge h, int32_t r) const {
    return mesh_.isFirst(h) ? PatchPoint{mesh_.edge(h), 0, r} : PatchPoint{mesh_.edge(h), size_, size_ - r};
  }
  // The same point on the square of the half-edge that ends there.
  PatchPoint acrossSeam(const PatchPoint& n) const {
    const HalfEdge first = mesh_.first(n.patch);
    const HalfEdge before = BaseMesh::previous(n.x == 0 ? first : mesh_.twin(first));
    const int32_t r = n.x == 0 ? n.y : size_ - n.y;
    return mesh_.isFirst(before) ? PatchPoint{mesh_.edge(before), size_ - r, size_}
                                 : PatchPoint{mesh_.edge(before), r, 0};
  }
  FacePoint facePointInHalf(HalfEdge h, int32_t x, int32_t y) const {
    FacePoint point{BaseMesh::face(h), {}};
    const uint32_t i = h % 3;
    point.weights[i] = static_cast<uint32_t>(3 * (size_ - y) + y - x);
    point.weights[(i + 1) % 3] = static_cast<uint32_t>(3 * x + y - x);
    point.weights[(i + 2) % 3] = static_cast<uint32_t>(y - x);
    return point;
  }

  // Bits of x and y in turn.
  static uint32_t morton(uint32_t x, uint32_t y) { return spread(x) | spread(y) << 1; }
  static uint32_t spread(uint32_t v) {
    v = (v | v << 8) & 0x00ff00ffu;
    v = (v | v << 4) & 0x0f0f0f0fu;
    v = (v | v << 2) & 0x33333333u;
    return (v | v << 1) & 0x55555555u;
  }
  static uint32_t unspread(uint32_t v) {
    v &= 0x55555555u;
    v = (v | v >> 1) & 0x33333333u;
    v = (v | v >> 2) & 0x0f0f0f0fu;
    v = (v | v >> 4) & 0x00ff00ffu;
    return (v | v >> 8) & 0x0000ffffu;
  }

  const BaseMesh& mesh_;
  uint32_t log2_;
  int32_t size_;
};

}  // namespace foreland::proto
