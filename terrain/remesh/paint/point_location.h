// The place of the original that belongs to a parameter of the remesh, between lattice vertices too. Pure; any thread.
#pragma once

#include "terrain/remesh/remesh.h"

namespace foreland::terrain {

// Under the point of the full mesh at `weights` of a base face's corners: found by walking over the original from the
// place of the nearest lattice vertex, so never on another part of it that lies near.
[[nodiscard]] SurfacePoint placeUnder(const Original& original, const Remeshed& remeshed, uint32_t face,
                                      const glm::dvec3& weights);

}  // namespace foreland::terrain
