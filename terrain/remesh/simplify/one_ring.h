// The faces around one vertex laid out in the plane, such that the vertex can be taken out and the polygon that is left
// be filled by a fan from one of its neighbours. Both fillings cover the same polygon, so they map each to the other
// one to one: the step from which the whole parametrisation is composed (after Liu et al., "Neural Subdivision", 2020,
// section 4: successive self-parametrisation; the layout is that of Lee et al., "MAPS", 1998, 3.3).
#pragma once

#include <array>
#include <cstdint>
#include <glm/vec2.hpp>
#include <span>
#include <vector>

#include "terrain/remesh/original/original.h"

namespace foreland::terrain {

// Face i holds the centre, ring[i] and ring[i + 1]; `corners` says which of the face's corners the centre is.
struct Ring {
  std::vector<uint32_t> vertices;  // counter-clockwise; if open, from border to border
  std::vector<uint32_t> faces;     // as many as vertices, or one fewer if open
  std::vector<uint8_t> corners;
  bool is_open = false;

  size_t size() const { return vertices.size(); }
  uint32_t next(size_t i) const { return vertices[i + 1 == vertices.size() ? 0 : i + 1]; }
};

// Fills `ring` with the faces at `centre`, which must be one fan.
void gatherRing(uint32_t centre, std::span<const uint32_t> faces_at, const std::vector<Triangle>& faces, Ring& ring);

// Two indices into the ring between which a path through the centre is laid out straight; the same for none.
using StraightPath = std::array<size_t, 2>;

// The ring's vertices about the centre at (0, 0): distances as in space, angles stretched evenly to fill the plane, or
// a half of it where the ring is open and on either side of a straight path. False if a face would turn over.
bool layOut(uint32_t centre, const Ring& ring, StraightPath path, const std::vector<glm::dvec3>& positions,
            std::vector<glm::dvec2>& flat);

// Whether the fan from ring vertex `kept` fills the laid-out polygon with proper triangles, none thinner than
// `least_quality` (see triangleQuality).
bool fanFills(const std::vector<glm::dvec2>& flat, size_t kept, bool is_open, double least_quality);

}  // namespace foreland::terrain
