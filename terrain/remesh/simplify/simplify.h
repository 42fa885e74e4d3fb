// Simplifies a surface to about a given number of triangles by half-edge collapses, cheapest first by quadric error,
// and keeps the map between the two. A vertex is collapsed into a neighbour, so base vertices are vertices of the
// original. Border vertices collapse along the border only; creases are weighted by what their loss would do to the
// shape, and a vertex removed along its crease leaves a crease behind. The topology is preserved: closed surfaces stay
// closed, holes stay holes.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "terrain/remesh/original/creases.h"
#include "terrain/remesh/original/original.h"
#include "terrain/remesh/simplify/coarse_map.h"

namespace foreland::terrain {

struct Base {
  std::vector<uint32_t> vertices;   // of each base vertex: its index in the original
  std::vector<Triangle> faces;      // indices into `vertices`
  std::vector<uint32_t> map_faces;  // of each face: its index in the map
  CoarseMap map;
  std::vector<Chain>
      feature_chains;  // the original's edges under each base edge that follows a border or crease, end to end
};

struct SimplifyOptions {
  uint32_t target_faces = 200;
  double crease_cosine = 0.766;          // of the angle between normals from which on an edge is a crease; 40 degrees
  std::span<const double> importance{};  // of each vertex: the weight of errors around it; empty: 1 everywhere
};

// May stop above the target, where every further collapse would change the topology or fold the surface.
// Single-threaded and deterministic. Cost: O(n log n).
[[nodiscard]] Base simplify(const Original& original, const SimplifyOptions& options);

}  // namespace foreland::terrain
