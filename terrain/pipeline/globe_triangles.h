// Places on a globe's lattice, and the triangles of bisection around them. Pure; any thread.
#pragma once

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "proto/space/cube_map.h"
#include "proto/topology/grid.h"
#include "terrain/bounds/bisection_triangle.h"

namespace foreland::terrain {

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
  BisectionTriangle coarsest(const Place& at) const {
    return BisectionTriangle::coarsest(static_cast<int>(grid_.rootSize()), at.p);
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
