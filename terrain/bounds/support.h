// The support of a node, triangle by triangle and row by row. A triangle (a, b, apex) halved by node n is right-angled
// and isosceles: with the offsets e = b - n and p = apex - n, a lattice point n + d has the coordinates u = d.e / |e|^2
// along the edge and v = d.p / |p|^2 towards the apex, 0 <= v <= 1 - |u|, and the surface without n is
//
//   value(d) = (A + B) / 2 + u (B - A) / 2 + v (P - (A + B) / 2)
//
// for any quantity A, B, P at the corners. Divisors are powers of two, so on integer heights it is exact in double.
// Pure; any thread.
#pragma once

#include <algorithm>
#include <cstdint>

#include "proto/topology/grid.h"

namespace foreland::terrain {

// An affine function of the offset (dx, dy) from the node.
template <class Value>
struct Plane {
  Value middle, per_x, per_y;
  Value at(int32_t dx, int32_t dy) const {
    return middle + static_cast<double>(dx) * per_x + static_cast<double>(dy) * per_y;
  }
};

struct SupportTriangle {
  proto::NodeId node, a, b, apex;
  int32_t ex, ey, px, py;  // offsets of b and of the apex from the node

  SupportTriangle(proto::NodeId n, const std::array<proto::NodeId, 2>& ends, proto::NodeId top)
      : node(n),
        a(ends[0]),
        b(ends[1]),
        apex(top),
        ex(offset(b.x(), n.x())),
        ey(offset(b.y(), n.y())),
        px(offset(top.x(), n.x())),
        py(offset(top.y(), n.y())) {}

  template <class Value>
  Plane<Value> plane(const Value& at_a, const Value& at_b, const Value& at_apex) const {
    const double inverse = 1.0 / (static_cast<double>(ex) * ex + static_cast<double>(ey) * ey);
    const Value middle = 0.5 * (at_a + at_b), along = 0.5 * inverse * (at_b - at_a),
                across = inverse * (at_apex - middle);
    return {middle, static_cast<double>(ex) * along + static_cast<double>(px) * across,
            static_cast<double>(ey) * along + static_cast<double>(py) * across};
  }

  // visit(dy, first_dx, last_dx) for every lattice row of the closed triangle, from the south.
  template <class Visit>
  void forEachRow(const Visit& visit) const {
    if (px == 0) {  // the edge is a row
      const int32_t s = std::abs(py);
      for (int32_t dy = std::min(py, 0); dy <= std::max(py, 0); ++dy) visit(dy, std::abs(dy) - s, s - std::abs(dy));
    } else if (py == 0) {  // the edge is a column
      const int32_t s = std::abs(px);
      for (int32_t dy = -s; dy <= s; ++dy) {
        const int32_t reach = s - std::abs(dy);
        px > 0 ? visit(dy, 0, reach) : visit(dy, -reach, 0);
      }
    } else {  // the edge is a diagonal of a square; the rows run from the apex's side to it
      const int32_t s = std::abs(px), slope = (px > 0) == (py > 0) ? -1 : 1;
      for (int32_t dy = -s; dy <= s; ++dy) px > 0 ? visit(dy, slope * dy, s) : visit(dy, -s, slope * dy);
    }
  }

 private:
  static int32_t offset(uint32_t to, uint32_t from) { return static_cast<int32_t>(to) - static_cast<int32_t>(from); }
};

}  // namespace foreland::terrain
