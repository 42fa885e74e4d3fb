// A globe's triangles of bisection around a point of a face's square, from the coarsest on. Pure; any thread.
#pragma once

#include <array>
#include <cmath>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "proto/space/cube_map.h"
#include "proto/topology/grid.h"

namespace foreland::terrain {

// A triangle that is halved between a and b, on a face's square; lattice steps.
struct FaceTriangle {
  glm::ivec2 a, b, apex;

  // One of the four that a face of so many steps a side begins as: the node of level 1 halves it.
  static FaceTriangle coarsest(int side, glm::dvec2 p) {
    const glm::dvec2 off = p - 0.5 * side;
    const glm::ivec2 corners[] = {{0, 0}, {side, 0}, {side, side}, {0, side}};
    const int at = std::fabs(off.x) > std::fabs(off.y) ? (off.x > 0 ? 1 : 3) : (off.y > 0 ? 2 : 0);
    return {corners[at], corners[(at + 1) % 4], glm::ivec2(side / 2)};
  }

  glm::ivec2 middle() const { return (a + b) / 2; }
  // The half with a point in it.
  FaceTriangle halfWith(glm::dvec2 p) const {
    // On which side of the line from the middle to the apex, along the edge from a to b.
    const glm::dvec2 along = b - a, off = p - glm::dvec2(middle());
    return along.x * off.x + along.y * off.y < 0 ? FaceTriangle{a, apex, middle()} : FaceTriangle{apex, b, middle()};
  }
  // How much its corners count at a point: a's, b's and the apex's.
  std::array<double, 3> sharesAt(glm::dvec2 p) const {
    const auto area = [](glm::dvec2 u, glm::dvec2 v) { return u.x * v.y - u.y * v.x; };
    const glm::dvec2 at_a(a), ab = glm::dvec2(b) - at_a, ac = glm::dvec2(apex) - at_a;
    const double all = area(ab, ac), of_b = area(p - at_a, ac) / all, of_apex = area(ab, p - at_a) / all;
    return {1 - of_b - of_apex, of_b, of_apex};
  }
};

// Places on the faces of a globe's lattice.
class GlobePlaces {
 public:
  explicit GlobePlaces(const proto::GridTopology& grid) : grid_(grid) {}

  struct Place {
    uint32_t face = 0;
    glm::dvec2 p{0};
  };
  Place placeOf(const glm::dvec3& direction) const {
    const proto::CubePoint at = proto::cubePoint(direction);
    const double half = 0.5 * grid_.rootSize();
    return {at.face, {(at.s + 1) * half, (at.t + 1) * half}};
  }
  FaceTriangle coarsest(const Place& at) const {
    return FaceTriangle::coarsest(static_cast<int>(grid_.rootSize()), at.p);
  }
  proto::NodeId nameOf(uint32_t face, glm::ivec2 p) const { return grid_.cube().name({face, p.x, p.y}); }
  glm::dvec3 directionOf(uint32_t face, glm::ivec2 p) const {
    const double step = 2.0 / grid_.rootSize();
    return proto::cubeVector({face, p.x * step - 1, p.y * step - 1});
  }

 private:
  const proto::GridTopology& grid_;
};

}  // namespace foreland::terrain
