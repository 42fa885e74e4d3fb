// Models in the coordinates of a map, or of the earth, lie far from (0, 0, 0). A surface's positions are whole numbers
// of small steps, and an object turns and grows about its origin, so such a model gets an origin of its own. Pure; any
// thread.
#pragma once

#include <glm/vec3.hpp>

#include "terrain/model/model.h"

namespace foreland::terrain {

// Whole numbers near the middle of an upright model's box, and below it; (0, 0, 0) unless the box is further from there
// than 10,000 units and ten of its diagonals.
[[nodiscard]] glm::dvec3 ownOrigin(const Model& model);

// Makes a point of the model its (0, 0, 0).
void moveTo(const glm::dvec3& origin, Model& model);

}  // namespace foreland::terrain
