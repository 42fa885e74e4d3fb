// What holds the squares of a globe's lattice, true or drawn: a square of scale t has a side of 2 s, s = 2^t, and all
// of its ground lies within the saturated error of its centre, which is a node, of the two triangles between its
// corners. Where that node is not there, a coarser square is taken that holds it. Nothing is held: what is asked for is
// read from the scene's pages.
//
// A view: the hierarchy must outlive it. Immutable; any thread. Cost: five nodes, about half a microsecond.
#pragma once

#include <array>
#include <cstdint>
#include <glm/vec3.hpp>
#include <optional>

#include "proto/refine/hidden/hidden_blocks.h"
#include "server/section/hierarchy.h"

namespace foreland::server {

class GlobeSquares {
 public:
  // The scene is a globe whose ground does not move.
  explicit GlobeSquares(const Hierarchy& hierarchy);

  // The hull of four points, and what is within so many metres of it. Scene frame.
  struct Hull {
    std::array<glm::dvec3, 4> corners;
    double error_m;
  };
  // Of the square with its corners at (2 s i, 2 s j) and (2 s (i + 1), 2 s (j + 1)). Nothing if that is a whole face or
  // more, or if nothing is known of it.
  std::optional<Hull> hullOf(uint32_t scale, uint32_t i, uint32_t j) const;
  // Whether a block lies at an edge of the cube, or is no part of one face. Nodes at edges go by blocks of their own
  // face alone, so these must not be hidden.
  bool isAtSeam(const proto::BlockId& block) const;

 private:
  const Hierarchy& hierarchy_;
  proto::DenseNodes nodes_;
  uint32_t face_log2_;
};

}  // namespace foreland::server
