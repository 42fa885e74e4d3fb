// The vertices at which a node's hat function is not zero, and what a sum of hat functions is there, given a
// coefficient for every node (S 3.2: the lazy wavelet expansion). The sum at a node is the mean of the sums at its
// endpoints plus its own coefficient, so the walk goes down the support's triangles and costs a step a vertex.
//
//   quadrisection  the hexagon of the node's own level, without its rim; coefficients of the node and its level's
//                  neighbours on the rim count, and of everything finer
//   bisection      the one or two triangles that the node halves, but for their corners
//
// A vertex is visited once or twice. Pure; any thread.
#pragma once

#include <algorithm>
#include <cstdlib>

#include "proto/topology/mesh_topology.h"

namespace foreland::terrain {

// Value: default construction is zero, sums, and products with numbers. coefficient(NodeId) -> Value;
// visit(NodeId, const Value&).
template <class Value, class Coefficient, class Visit>
class SupportWalk {
 public:
  SupportWalk(const proto::MeshTopology& mesh, const Coefficient& coefficient, const Visit& visit)
      : mesh_(mesh), coefficient_(coefficient), visit_(visit) {}

  void run(proto::NodeId node) {
    const proto::PatchPoint n = proto::patchPointOf(node);
    if (mesh_.rule() == proto::MeshRule::kQuadrisection)
      hexagon(node, n);
    else
      halves(node, n);
  }

 private:
  struct Corner {
    proto::PatchPoint at;
    Value value;
  };

  static Value middle(const Value& a, const Value& b) { return (a + b) * 0.5; }

  void hexagon(proto::NodeId node, const proto::PatchPoint& n) {
    const proto::Quadrisection rule = mesh_.quad();
    const int32_t s = 1 << n.scaleLog2();
    const int level = rule.level(n);
    const Value own = coefficient_(node);
    visit_(node, own);
    const auto corner = [&](const proto::PatchPoint& p) {
      const proto::NodeId v = rule.name(p);
      return Corner{p, mesh_.level(v) == level ? coefficient_(v) : Value{}};
    };
    const int32_t offsets[7][2] = {{s, 0}, {0, s}, {-s, s}, {-s, 0}, {0, -s}, {s, -s}, {s, 0}};
    for (const proto::PatchPoint& centre : rule.appearances(n))
      for (int i = 0; i < 6; ++i) {
        const proto::PatchPoint b = centre.moved(offsets[i][0], offsets[i][1]),
                                c = centre.moved(offsets[i + 1][0], offsets[i + 1][1]);
        if (rule.isInPatch(b) && rule.isInPatch(c)) split({centre, own}, corner(b), corner(c), centre, s, s / 2);
      }
  }

  // `half` of the triangle's sides; the hexagon of `s` about `centre` is what is visited.
  void split(const Corner& a, const Corner& b, const Corner& c, const proto::PatchPoint& centre, int32_t s,
             int32_t half) {
    if (half == 0) return;
    const auto between = [&](const Corner& p, const Corner& q) {
      const proto::PatchPoint at{p.at.patch, (p.at.x + q.at.x) / 2, (p.at.y + q.at.y) / 2};
      const proto::NodeId v = mesh_.quad().name(at);
      const Corner m{at, middle(p.value, q.value) + coefficient_(v)};
      const int32_t dx = at.x - centre.x, dy = at.y - centre.y;
      if (std::max({std::abs(dx), std::abs(dy), std::abs(dx + dy)}) < s) visit_(v, m.value);
      return m;
    };
    const Corner ab = between(a, b), bc = between(b, c), ca = between(c, a);
    split(a, ab, ca, centre, s, half / 2);
    split(ab, b, bc, centre, s, half / 2);
    split(ca, bc, c, centre, s, half / 2);
    split(bc, ca, ab, centre, s, half / 2);
  }

  // A triangle by the middle of its refinement edge, half of that edge, and values at its ends and at its apex.
  struct Half {
    proto::PatchPoint middle;
    int32_t dx, dy;
    Value a, b, apex;
  };

  void halves(proto::NodeId node, const proto::PatchPoint& n) {
    const proto::Bisection rule = mesh_.bisect();
    const int levels = mesh_.maxLevel() - rule.level(n);
    for (const proto::PatchPoint& p : rule.appearances(n)) {
      const auto [dx, dy] = rule.halfEdgeAt(p);
      for (int sign : {1, -1})
        if (rule.isInPatch(p.moved(-sign * dy, sign * dx))) halve(node, {p, sign * dx, sign * dy, {}, {}, {}}, levels);
    }
  }

  void halve(proto::NodeId node, const Half& t, int levels) {
    const Value value = middle(t.a, t.b) + coefficient_(node);
    visit_(node, value);
    if (levels == 0) return;
    const int32_t in_x = (-t.dy - t.dx) / 2, in_y = (t.dx - t.dy) / 2, on_x = in_y, on_y = -in_x;
    const proto::PatchPoint one = t.middle.moved(in_x, in_y), other = t.middle.moved(on_x, on_y);
    halve(mesh_.bisect().name(one), {one, -on_x, -on_y, t.apex, t.a, value}, levels - 1);
    halve(mesh_.bisect().name(other), {other, in_x, in_y, t.b, t.apex, value}, levels - 1);
  }

  const proto::MeshTopology& mesh_;
  const Coefficient& coefficient_;
  const Visit& visit_;
};

}  // namespace foreland::terrain
