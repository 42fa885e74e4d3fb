// Which faces of a surface to flip, so that it is oriented consistently and outward. Pure; any thread.
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <vector>

#include "terrain/remesh/original/original.h"

namespace foreland::terrain {

struct Orientation {
  std::vector<bool> is_flipped;  // of each face: whether its corners must be reversed
  uint32_t non_orientable_face =
      kNoIndex;  // where a non-orientable surface contradicts itself; `is_flipped` is then incomplete
};

// Each connected component takes the orientation of the majority of its faces. Then, if the closed components enclose a
// negative volume in sum, all of them are flipped: the file has its normals inward. (A cavity has a negative volume of
// its own, and keeps it.)
[[nodiscard]] Orientation findOrientation(const std::vector<glm::dvec3>& positions, const std::vector<Triangle>& faces,
                                          const std::vector<Triangle>& twins);

}  // namespace foreland::terrain
