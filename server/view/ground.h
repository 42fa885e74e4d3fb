// The ground of a scene at any lattice place, from its full-resolution samples. Immutable; any thread; O(1).
#pragma once

#include <optional>

#include "terrain/store/scene.h"

namespace foreland::server {

// Metres above the zero surface, bilinear between samples; nothing beyond the data or for coordinates that are not
// finite.
std::optional<double> groundHeight(const terrain::Scene& scene, double lattice_x, double lattice_y);

}  // namespace foreland::server
