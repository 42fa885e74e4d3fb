// The ground of a globe at full resolution, for lines of sight: the triangles of bisection (proto/topology/grid.h),
// from the roots of the six faces to the finest whose nodes are there. Nothing is made of it before, and nothing is
// held: a line goes down through the scene's own pages. What makes that cheap is the nodes' saturated errors: all of
// the ground over a triangle lies within the error of the node that halves it, so a line that passes farther by needs
// none of what is below. Of a line a few nodes of each coarse level are read, and of the fine ones those that it comes
// as near as their errors.
//
// Positions are those of the vertices, the same bits from both faces that share an edge of the cube, and midpoints
// halve an edge for both of its triangles; so faces, corners and poles are nothing special here.
//
// A view: the hierarchy must outlive it. Immutable; any thread.
#pragma once

#include <array>
#include <cstdint>
#include <glm/vec3.hpp>
#include <optional>

#include "server/section/globe_triangles.h"
#include "server/sight/sight_line.h"

namespace foreland::server {

class TriangleTree {
 public:
  // The scene is a globe.
  explicit TriangleTree(const Hierarchy& hierarchy);

  // Scene frame: on the triangle of the finest nodes there, which is flat also where the zero surface is not, where the
  // lattice position lies between its corners' own. Nothing beyond the lattice.
  std::optional<glm::dvec3> pointAt(double lattice_x, double lattice_y, const proto::EpochWeights& time) const;

  enum class Wanted : uint8_t { kFirst, kAny };
  // The first place of the line, or any, where the ground hides its end: a share less than `before`, or nothing. `work`
  // is raised by the number of triangles that were looked at.
  std::optional<double> meet(const SightLine& line, Wanted wanted, double before, const proto::EpochWeights& time,
                             uint64_t& work) const;

 private:
  struct Vertex {
    int32_t x = 0, y = 0;  // on the face's square
    glm::dvec3 position{0};
  };
  // Of the node that halves a triangle's longest edge, from `a` to `b`.
  struct Node {
    Vertex vertex;
    double error_m = 0;
  };
  class Walk;

  Vertex placed(const GlobeTriangles::Vertex& vertex, const proto::EpochWeights& time) const;
  // Nothing if the triangle is of the finest there are.
  std::optional<Node> halfway(uint32_t face, const Vertex& a, const Vertex& b, int level,
                              const proto::EpochWeights& time) const;
  // The four triangles of a face: each of two corners that follow each other, and the middle.
  struct Face {
    std::array<Vertex, 4> corners;
    Vertex middle;
  };
  Face faceOf(uint32_t face, const proto::EpochWeights& time) const;

  const Hierarchy& hierarchy_;
  GlobeTriangles triangles_;
};

}  // namespace foreland::server
