// The surface that is to be remeshed: the triangles of a model, welded where its vertices coincide, turned so that
// neighbours agree, and proved to be a manifold with or without border. Everything later relies on it. Immutable once
// made; any thread may read it.
#pragma once

#include <array>
#include <cstdint>
#include <glm/vec3.hpp>
#include <vector>

#include "base/result.h"
#include "terrain/model/model.h"

namespace foreland::terrain {

using Triangle = std::array<uint32_t, 3>;  // vertices, counter-clockwise seen from outside

struct Original {
  std::vector<glm::dvec3> positions;  // those that a face uses
  std::vector<Triangle> faces;
  std::vector<Triangle> across;  // beyond edge k (from corner k to the next): 3 * face + its edge; kNoIndex at a border

  // Where it came from, for colours and for messages.
  std::vector<uint32_t> source_vertices;                // the model's first vertex at each position
  std::vector<uint32_t> source_faces;                   // the model's face of each triangle
  std::vector<std::array<uint64_t, 3>> source_corners;  // indices into Model::corners
  uint64_t welded = 0, turned = 0;                      // vertices merged; faces of the model turned over
};

// Errors name the model's first offending face or vertex: a face whose outline meets itself or has no area, an edge of
// more than two faces, a vertex at which several sheets touch, a surface with one side only, a model without extent.
// Cost: n log n.
[[nodiscard]] Result<Original> makeOriginal(const Model& model);

// Across which edge is the neighbour: the table of `Original::across`, or the first edge that has a third face.
struct Adjacency {
  std::vector<Triangle> across;
  uint32_t crowded_face = kNoIndex;  // a face at an edge of more than two faces; `across` is then incomplete
  uint32_t crowded_edge = 0;
};
[[nodiscard]] Adjacency findAdjacency(const std::vector<Triangle>& faces);

}  // namespace foreland::terrain
