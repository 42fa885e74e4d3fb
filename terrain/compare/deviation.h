// How far two meshes lie apart, and whether one of them folds. `foreland remesh` reports these of its result; no code
// is shared with the remesher. Any thread; uses threads of its own while it runs; the result does not depend on their
// number.
#pragma once

#include <cstdint>
#include <vector>

#include "terrain/compare/closest.h"

namespace foreland::terrain {

// Largest distance from a point of `from` to the closest one of `to` (one side of the Hausdorff distance), over all
// points of all triangles: triangles are cut until none can exceed what is found by more than `tolerance`. So the true
// value is at least the result and at most `tolerance` more. A cut triangle's distances are bounded by those of its
// corners to one triangle (the distance to a convex set is convex) and by its centre's plus its radius.
[[nodiscard]] double largestDistance(MeshView from, const ClosestPoint& to, double tolerance, unsigned threads);

// Triangles of `mesh` that face away from the surface at the point closest to their centroid, or have no area;
// ascending. On an edge or at a corner the surface faces as its angle-weighted normal does (Baerentzen and Aanaes,
// 2005).
[[nodiscard]] std::vector<uint32_t> findFlipped(MeshView mesh, const ClosestPoint& surface, unsigned threads);

}  // namespace foreland::terrain
