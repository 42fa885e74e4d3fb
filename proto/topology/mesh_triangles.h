// The triangles of a section on a surface: from the base faces downward, without cracks and without T-vertices.
//
//   bisection      a triangle is halved while the node of its refinement edge is in the section; since the section is
//                  closed under parents, its neighbour is halved, too
//   quadrisection  a triangle is split in four while the node of any of its edges is in the section. Where the neighbour
//                  across an edge is split and the triangle is not, the edge's middle is a vertex, too: the triangle is
//                  cut there, and each half again (S 3.6). Such a vertex is not in the section and lies on the edge, so
//                  cutting does not change the surface.
//
// So vertices are base vertices, nodes of the section and, by quadrisection, other nodes, whose position is the middle
// of their endpoints, as THEORY section 2 defines it for every node. `is_in_section(NodeId)` must be closed under
// parents; by quadrisection it may have mayHold(half), which is asked first: whether it holds nodes that halve edges of
// twice as many lattice intervals, or finer ones. Triangles turn as their base face does. Pure; any thread;
// O(triangles), no allocation.
#pragma once

#include <array>

#include "proto/topology/mesh_topology.h"

namespace foreland::proto {

namespace mesh_triangles {

template <class IsInSection, class Visit>
class Quadrisected {
 public:
  Quadrisected(const MeshTopology& mesh, uint32_t face, const IsInSection& is_in_section, const Visit& visit)
      : rule_(mesh.quad()), face_(face), is_in_section_(is_in_section), visit_(visit) {}

  void run(int32_t size) { split({0, 0}, {size, 0}, {0, size}, size / 2); }

 private:
  struct Point {
    int32_t x, y;
  };
  // A side of a triangle that is being cut: from its corner to the next. `half` of its length, 0 if it cannot be cut.
  struct Corner {
    Point at;
    int32_t half;
  };

  static Point middle(Point p, Point q) { return {(p.x + q.x) / 2, (p.y + q.y) / 2}; }
  PatchPoint onPatch(Point p) const { return {face_, p.x, p.y}; }
  bool isInSection(Point p) const { return is_in_section_(rule_.name(onPatch(p))); }
  // Whether the section may hold nodes that halve edges of twice `half`.
  bool isFineEnough(int32_t half) const {
    if constexpr (requires { is_in_section_.mayHold(half); })
      return is_in_section_.mayHold(half);
    else
      return true;
  }
  // If the node or one of its siblings is in the section, a triangle beside its edge is split.
  bool isVertex(Point p, int32_t half) const {
    if (!isFineEnough(half)) return false;
    const NodeId n = rule_.name(onPatch(p));
    if (is_in_section_(n)) return true;
    for (NodeId sibling : rule_.siblings(patchPointOf(n)))
      if (is_in_section_(sibling)) return true;
    return false;
  }

  // `half` of the triangle's sides, in lattice intervals.
  void split(Point a, Point b, Point c, int32_t half) {
    const Point ab = middle(a, b), bc = middle(b, c), ca = middle(c, a);
    if (half == 0 || !isFineEnough(half) || !(isInSection(ab) || isInSection(bc) || isInSection(ca)))
      return cut({Corner{a, half}, Corner{b, half}, Corner{c, half}});
    split(a, ab, ca, half / 2);
    split(ab, b, bc, half / 2);
    split(ca, bc, c, half / 2);
    split(bc, ca, ab, half / 2);
  }

  // The longest side first.
  void cut(const std::array<Corner, 3>& t) {
    int longest = -1;
    for (int i = 0; i < 3; ++i) {
      const int32_t half = t[i].half;
      if (half > 0 && (longest < 0 || half > t[longest].half) && isVertex(middle(t[i].at, t[(i + 1) % 3].at), half))
        longest = i;
    }
    if (longest < 0) return visit_(name(t[0]), name(t[1]), name(t[2]));
    const Corner &p = t[longest], &q = t[(longest + 1) % 3], &apex = t[(longest + 2) % 3];
    const int32_t half = p.half / 2;
    const Point m = middle(p.at, q.at);
    cut({Corner{p.at, half}, Corner{m, 0}, apex});
    cut({Corner{m, half}, q, Corner{apex.at, 0}});
  }
  NodeId name(const Corner& c) const { return rule_.name(onPatch(c.at)); }

  const Quadrisection rule_;
  uint32_t face_;
  const IsInSection& is_in_section_;
  const Visit& visit_;
};

template <class IsInSection, class Visit>
class Bisected {
 public:
  Bisected(const MeshTopology& mesh, HalfEdge h, const IsInSection& is_in_section, const Visit& visit)
      : rule_(mesh.bisect()), patch_(mesh.base().edge(h)), is_in_section_(is_in_section), visit_(visit) {}

  // The half of the square that the half-edge is in: its ends are (0, 0) and (size, size), or the other way round.
  void run(int32_t size, bool is_first, int levels) {
    const int32_t half = size / 2, d = is_first ? half : -half;
    const Triangle t{half, half, d, d};
    halve(t, {name(half - d, half - d), name(half + d, half + d), name(half - d, half + d)}, levels);
  }

 private:
  // Ends of the refinement edge m - d and m + d, apex m + (-d.y, d.x).
  struct Triangle {
    int32_t mx, my, dx, dy;
  };

  NodeId name(int32_t x, int32_t y) const { return rule_.name({patch_, x, y}); }

  void halve(const Triangle& t, const std::array<NodeId, 3>& corners, int levels) {
    const NodeId n = levels > 0 ? name(t.mx, t.my) : NodeId{};
    if (levels == 0 || !is_in_section_(n)) return visit_(corners[0], corners[1], corners[2]);
    const int32_t in_x = (-t.dy - t.dx) / 2, in_y = (t.dx - t.dy) / 2;
    const int32_t on_x = (t.dx - t.dy) / 2, on_y = (t.dx + t.dy) / 2;
    halve({t.mx + in_x, t.my + in_y, -on_x, -on_y}, {corners[2], corners[0], n}, levels - 1);
    halve({t.mx + on_x, t.my + on_y, in_x, in_y}, {corners[1], corners[2], n}, levels - 1);
  }

  const Bisection rule_;
  uint32_t patch_;
  const IsInSection& is_in_section_;
  const Visit& visit_;
};

}  // namespace mesh_triangles

// Calls visit(a, b, c) with the ids of each triangle's vertices, for one base face.
template <class IsInSection, class Visit>
void forEachTriangleOf(const MeshTopology& mesh, uint32_t face, const IsInSection& is_in_section, const Visit& visit) {
  const int32_t size = 1 << mesh.halvings();
  if (mesh.rule() == MeshRule::kQuadrisection)
    return mesh_triangles::Quadrisected(mesh, face, is_in_section, visit).run(size);
  for (HalfEdge h = 3 * face; h < 3 * face + 3; ++h)
    mesh_triangles::Bisected(mesh, h, is_in_section, visit).run(size, mesh.base().isFirst(h), mesh.maxLevel());
}

// The same for all base faces, in order.
template <class IsInSection, class Visit>
void forEachTriangle(const MeshTopology& mesh, const IsInSection& is_in_section, const Visit& visit) {
  for (uint32_t face = 0; face < mesh.base().faceCount(); ++face) forEachTriangleOf(mesh, face, is_in_section, visit);
}

}  // namespace foreland::proto
