// The ground of a globe about a place as heights over lattices in the plane that touches it there, for horizons
// (horizon_grid.h): all ground over a square about a vertex, so wide that not only no line between two neighbours lies
// above the ground, but all ground within a spacing of any point of such a line, to any side, lies above it. That room
// is for ground that is drawn elsewhere than it is (horizon.h).
//
// Found by a walk down the triangles of the scene's own pages (server/section/globe_triangles.h): what lies below a
// triangle is left out where the node that halves it says that all of it is nearer than a share of the spacing.
#pragma once

#include <cstdint>
#include <glm/vec2.hpp>
#include <optional>
#include <stop_token>
#include <vector>

#include "server/occlusion/horizon/local_plane.h"
#include "server/section/hierarchy.h"

namespace foreland::server {

// Of a level of a lattice.
struct LevelHeights {
  uint32_t columns, rows;
  std::vector<float> heights_m;  // row by row
};

struct GlobeHeights {
  LocalPlane plane;
  glm::dvec2 low_m{0};               // of vertex (0, 0), in the plane
  double spacing_m = 1;              // of vertices of level 0
  std::vector<LevelHeights> levels;  // of each, of twice the spacing of the one before; z of the plane
};

// How far from the place, along x and y of the plane, heights are known; a part of a small body.
double globeHeightsReach(const proto::Frame& frame);

// The scene is a globe whose ground does not move. Nothing if it was asked to stop. O(triangles in reach): a second of
// one processor over mountains, and 60 MB for that time.
std::optional<GlobeHeights> globeHeights(const Hierarchy& hierarchy, const LocalPlane& plane,
                                         const std::stop_token& stop);

}  // namespace foreland::server
