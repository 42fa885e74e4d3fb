// The surface to be remeshed: the triangles of a model, welded where its vertices coincide, oriented consistently, and
// proved to be a manifold with or without border. The other rooms of the remesher rely on that. Immutable once made;
// any thread may read it.
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
  std::vector<glm::dvec3> positions;  // of the vertices that a face uses
  std::vector<Triangle> faces;
  // For edge k of each face, from corner k to the next: the same edge in the neighbouring face, as 3 * face + edge;
  // kNoIndex at a border.
  std::vector<Triangle> twins;

  // Where each element came from in the model, for colours and for messages.
  std::vector<uint32_t> source_vertices;                // the model's first vertex at each position
  std::vector<uint32_t> source_faces;                   // the model's face of each triangle
  std::vector<std::array<uint64_t, 3>> source_corners;  // indices into Model::corners
  uint64_t welded = 0, flipped = 0;                     // vertices merged; faces of the model whose orientation changed
};

// Errors name the model's first offending face or vertex: a face whose outline meets itself or has no area, a
// non-manifold edge or vertex, a non-orientable surface, a model without extent. Cost: O(n log n).
[[nodiscard]] Result<Original> makeOriginal(const Model& model);

// The table of Original::twins for any triangles, or the first face that is the third at one of its edges.
struct Adjacency {
  std::vector<Triangle> twins;
  uint32_t non_manifold_face = kNoIndex;  // kNoIndex if every edge has at most two; else `twins` is incomplete
  uint32_t non_manifold_edge = 0;
};
[[nodiscard]] Adjacency findAdjacency(const std::vector<Triangle>& faces);

}  // namespace foreland::terrain
