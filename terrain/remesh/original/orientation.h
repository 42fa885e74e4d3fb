// Which faces of a surface to turn over, so that neighbours agree on what is outside. Pure; any thread.
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <vector>

#include "terrain/remesh/original/original.h"

namespace foreland::terrain {

struct Orientation {
  std::vector<bool> turns;        // of each face: it must be turned over
  uint32_t one_sided = kNoIndex;  // a face at which a surface with one side only closes; `turns` is then unfinished
};

// Each connected part turns as most of its faces lie; then all closed parts together, if they enclose a negative
// volume: the file then has its normals inwards. (Cavities have a negative one of their own, and keep it.)
[[nodiscard]] Orientation findOrientation(const std::vector<glm::dvec3>& positions, const std::vector<Triangle>& faces,
                                          const std::vector<Triangle>& across);

}  // namespace foreland::terrain
