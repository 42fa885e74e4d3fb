// The height of the ground of a scene at any lattice position, from its full-resolution samples. Pure; any thread;
// O(1).
#pragma once

#include <optional>

#include "terrain/store/scene.h"

namespace foreland::server {

// Metres above the zero surface, bilinear between samples. Nothing for a position beyond the data or with coordinates
// that are not finite.
std::optional<double> groundHeight(const terrain::Scene& scene, double lattice_x, double lattice_y);

}  // namespace foreland::server
