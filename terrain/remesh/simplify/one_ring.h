// The one-ring of a vertex (the faces around it) flattened to the plane, so that the vertex can be removed and the
// polygon that is left be triangulated by a fan from one of its neighbours. Both triangulations cover the same polygon,
// so each maps to the other one to one: the step from which the whole parametrisation is composed (after Liu et al.,
// "Neural Subdivision", 2020, section 4: successive self-parametrisation; the flattening is that of Lee et al., "MAPS",
// 1998, 3.3).
#pragma once

#include <array>
#include <cstdint>
#include <glm/vec2.hpp>
#include <span>
#include <vector>

#include "terrain/remesh/original/original.h"

namespace foreland::terrain {

// Face i has the corners centre, vertices[i] and vertices[i + 1]; corners[i] is the index of the centre among them.
struct OneRing {
  std::vector<uint32_t> vertices;  // counter-clockwise; of an open ring, from border to border
  std::vector<uint32_t> faces;     // as many as vertices, or one fewer if open
  std::vector<uint8_t> corners;
  bool is_open = false;

  size_t size() const { return vertices.size(); }
  uint32_t next(size_t i) const { return vertices[i + 1 == vertices.size() ? 0 : i + 1]; }
};

// Writes the one-ring of `centre` to `ring`. The faces at a vertex must form one fan.
void gatherOneRing(uint32_t centre, std::span<const uint32_t> faces_at, const std::vector<Triangle>& faces,
                   OneRing& ring);

// Two indices into the ring: the path from one to the other through the centre becomes a straight line. Equal: no path.
using StraightPath = std::array<size_t, 2>;

// Positions of the ring's vertices in the plane, the centre at (0, 0): distances from it as in space, angles scaled
// evenly to a full turn, or to half a turn where the ring is open and on either side of a straight path. False if a
// face would flip.
bool flatten(uint32_t centre, const OneRing& ring, StraightPath path, const std::vector<glm::dvec3>& positions,
             std::vector<glm::dvec2>& flat);

// Whether the fan from ring vertex `kept` triangulates the flattened polygon without flipped triangles, all of at least
// `min_quality` (triangleQuality).
bool isValidFan(const std::vector<glm::dvec2>& flat, size_t kept, bool is_open, double min_quality);

}  // namespace foreland::terrain
