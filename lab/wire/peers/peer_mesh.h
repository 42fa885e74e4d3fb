// A mesh as it is put before other makers' codecs, and what one of them made of it. Plain data.
//
// The caller chooses the space of the positions: the scene's metres, or the lattice (x and y in samples, height in
// quanta), whose integers the exact codecs take.
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <vector>

#include "base/bytes.h"

namespace foreland::lab {

struct PeerMesh {
  std::vector<glm::dvec3> positions;
  std::vector<uint32_t> indices;  // triangles; every vertex is of one
};

struct PeerCode {
  Bytes bytes;
  PeerMesh decoded;         // from the bytes alone, in an order of its own
  glm::dvec3 tolerance{0};  // how far the codec says a vertex may have moved, by axis, in the units of the mesh
};

// The box around the positions. The mesh is not empty.
struct Box {
  glm::dvec3 low, high;
};
Box boxAround(const PeerMesh& mesh);

}  // namespace foreland::lab
