// Straight walks over a triangle mesh: across an edge the way goes on straight in the plane of the next face, so one
// can not leave the surface, nor jump to another part of it that happens to lie near. Any thread.
#pragma once

#include "terrain/remesh/original/surface_point.h"

namespace foreland::terrain {

// From `at` along the part of `step` that lies in its face's plane, as far as that is long. It ends at a border, and
// where `across`, the table of what lies beyond each edge, says that nothing does.
[[nodiscard]] SurfacePoint walk(const Original& surface, const std::vector<Triangle>& across, SurfacePoint at,
                                glm::dvec3 step);

}  // namespace foreland::terrain
