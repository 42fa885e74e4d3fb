// The height of the ground of a scene at any lattice position, from its full-resolution samples: of the highest ground
// at any time, in scenes that change. Pure; any thread; O(epochs).
#pragma once

#include <glm/vec3.hpp>
#include <optional>

#include "terrain/store/scene.h"

namespace foreland::server {

// Metres above the zero surface, bilinear between samples. Nothing for a position beyond the data or with coordinates
// that are not finite.
std::optional<double> groundHeight(const terrain::Scene& scene, double lattice_x, double lattice_y);

// How high a point of the scene frame is above the ground, or above the nearest ground of the data's border; metres, 0
// for points below it.
double heightAboveGround(const terrain::Scene& scene, const glm::dvec3& point);

}  // namespace foreland::server
