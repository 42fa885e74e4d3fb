// Straight lines on a triangle mesh: across an edge the line continues straight in the plane of the next face (Polthier
// and Schmies, "Straightest geodesics on polyhedral surfaces", 1998), so it can neither leave the surface nor jump to
// another part of it that lies near. Any thread.
#pragma once

#include "terrain/remesh/original/surface_point.h"

namespace foreland::terrain {

// The end of the line that starts at `at` along the component of `step` in the plane of its face, and is as long as
// that component. The line stops early at edges without a neighbour in `twins` (see Original), so callers may block
// edges.
[[nodiscard]] SurfacePoint traceGeodesic(const Original& surface, const std::vector<Triangle>& twins, SurfacePoint at,
                                         glm::dvec3 step);

}  // namespace foreland::terrain
