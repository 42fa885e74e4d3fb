// The triangles of bisection (proto/topology/grid.h) over a globe's faces, from the roots to the finest whose nodes are
// there: what goes down through the scene's own pages asks here which node halves a triangle. Positions on a face are
// those of its square; names are the scene's, the same from both faces that share an edge of the cube.
//
// A view: the hierarchy must outlive it. Immutable; any thread.
#pragma once

#include <cstdint>
#include <optional>

#include "server/section/hierarchy.h"

namespace foreland::server {

class GlobeTriangles {
 public:
  // The scene is a globe.
  explicit GlobeTriangles(const Hierarchy& hierarchy);

  int32_t side() const { return side_; }  // of a face, lattice steps

  struct Vertex {
    int32_t x = 0, y = 0;  // on the face's square
    proto::NodeId name;
    int32_t height = 0;  // quanta, at the first epoch
  };
  // A corner of a face, or its middle.
  Vertex base(uint32_t face, int32_t x, int32_t y) const;

  // The node that halves a triangle's longest edge. All of the ground over the triangle, and over the other one at that
  // edge, lies within its error of these triangles.
  struct Node {
    Vertex vertex;
    double error_m = 0;
  };
  // Of an edge from (ax, ay) to (bx, by), that a node of this level halves. Nothing if the triangle is of the finest
  // there are.
  std::optional<Node> halfway(uint32_t face, int32_t ax, int32_t ay, int32_t bx, int32_t by, int level) const;

 private:
  const proto::GridTopology& grid_;
  proto::DenseNodes nodes_;
  int32_t side_;
};

}  // namespace foreland::server
