// Triangles of bisection on a root square, from the coarsest on (proto/topology/grid.h). Pure; any thread.
#pragma once

#include <array>
#include <cmath>
#include <glm/vec2.hpp>

namespace foreland::terrain {

// A triangle that is halved between a and b; lattice steps.
struct BisectionTriangle {
  glm::ivec2 a, b, apex;

  // One of the four that a square of so many steps a side begins as, (0, 0) its south-western corner: nodes of level 1
  // halve them.
  static BisectionTriangle coarsest(int side, glm::dvec2 p) {
    const glm::dvec2 off = p - 0.5 * side;
    const glm::ivec2 corners[] = {{0, 0}, {side, 0}, {side, side}, {0, side}};
    const int at = std::fabs(off.x) > std::fabs(off.y) ? (off.x > 0 ? 1 : 3) : (off.y > 0 ? 2 : 0);
    return {corners[at], corners[(at + 1) % 4], glm::ivec2(side / 2)};
  }

  glm::ivec2 middle() const { return (a + b) / 2; }
  // The half with a point in it.
  BisectionTriangle halfWith(glm::dvec2 p) const {
    // On which side of the line from the middle to the apex, along the edge from a to b.
    const glm::dvec2 along = b - a, off = p - glm::dvec2(middle());
    return along.x * off.x + along.y * off.y < 0 ? BisectionTriangle{a, apex, middle()}
                                                 : BisectionTriangle{apex, b, middle()};
  }
  // How much its corners count at a point: a's, b's and the apex's.
  std::array<double, 3> sharesAt(glm::dvec2 p) const {
    const auto area = [](glm::dvec2 u, glm::dvec2 v) { return u.x * v.y - u.y * v.x; };
    const glm::dvec2 at_a(a), ab = glm::dvec2(b) - at_a, ac = glm::dvec2(apex) - at_a;
    const double all = area(ab, ac), of_b = area(p - at_a, ac) / all, of_apex = area(ab, p - at_a) / all;
    return {1 - of_b - of_apex, of_b, of_apex};
  }
};

}  // namespace foreland::terrain
