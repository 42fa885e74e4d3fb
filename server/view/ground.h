// The height of the ground of a scene at any lattice position, from its full-resolution samples: of the highest ground
// at any time, in scenes that change. Pure; any thread; O(epochs).
#pragma once

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <optional>
#include <span>
#include <vector>

#include "terrain/store/scene.h"

namespace foreland::server {

// Metres above the zero surface, bilinear between samples. Nothing for a position beyond the data or with coordinates
// that are not finite.
std::optional<double> groundHeight(const terrain::Scene& scene, double lattice_x, double lattice_y);

// How far the sea lies above the zero surface at lattice positions, metres: nothing unless that is the ellipsoid and
// the scene knows a geoid.
std::vector<float> seaAboveZero(const terrain::Scene& scene, std::span<const glm::dvec2> positions);

// How high a point of the scene frame is above the ground, or above the nearest ground of the data's border; metres, 0
// for points below it.
double heightAboveGround(const terrain::Scene& scene, const glm::dvec3& point);

}  // namespace foreland::server
