// The directions that the planes of inner solids may have: those that a surface faces most, and the three of a box that
// stands as its largest wall does. Pure; any thread.
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <vector>

#include "terrain/surface/full_mesh.h"

namespace foreland::terrain {

using DirectionSets = std::vector<std::vector<uint32_t>>;  // of indices

struct Directions {
  std::vector<glm::dvec3> all;  // unit, into the surface
  DirectionSets sets;           // each of at most ConvexSolid::kMaxPlanes that together bound a solid
};

// O(triangles).
Directions chooseDirections(const FullMesh& mesh);

}  // namespace foreland::terrain
