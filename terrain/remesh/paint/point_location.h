// Locates on the original what a parameter of the remesh stands for, between lattice vertices too. Pure; any thread.
#pragma once

#include "terrain/remesh/remesh.h"

namespace foreland::terrain {

// The point of the original under the full mesh at barycentric `weights` of a base face. Walking point location: it
// traces over the original from the point of the nearest lattice vertex, so it never ends on another part that lies
// near.
[[nodiscard]] SurfacePoint locateOnOriginal(const Original& original, const Remeshed& remeshed, uint32_t face,
                                            const glm::dvec3& weights);

}  // namespace foreland::terrain
