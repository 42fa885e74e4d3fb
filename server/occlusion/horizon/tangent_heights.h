// The ground of a geographic scene as heights over a lattice in the plane that touches the earth at the scene's origin,
// for horizons (horizon_grid.h): there lines of sight are straight, and the bend of the earth is a part of the heights.
//
// A vertex is as high as the lowest ground of the four cells about it, so that no line between two neighbours lies
// above the ground. The ground of a cell is bounded by the triangles of the samples' cells, cut by either diagonal: by
// their lowest corners, and by their planes over the cell.
#pragma once

#include <glm/vec2.hpp>
#include <optional>
#include <vector>

#include "server/section/hierarchy.h"

namespace foreland::server {

struct TangentHeights {
  glm::dvec2 low_m{0};   // of vertex (0, 0), in the scene's axes
  double spacing_m = 1;  // of vertices, along x and y of the scene
  uint32_t columns = 0, rows = 0;
  std::vector<float> heights_m;  // the scene's z; row by row
};

// None if the frame is planar, or the scene goes on so far that it is hardly a field of heights over one plane. Four
// vertices to a sample's spacing along either axis, or fewer so that there are no more than `max_vertices`.
// O(samples + vertices).
std::optional<TangentHeights> tangentHeights(const Hierarchy& hierarchy, size_t max_vertices);

}  // namespace foreland::server
