// The surface to be remeshed: the triangles of a model, welded where its vertices coincide, oriented consistently, and
// proved to be a manifold with or without border. The other rooms of the remesher rely on that. Immutable once made;
// any thread may read it.
//
// A model that is no such surface is refused, or repaired where that changes no point of it: repeated corners, faces
// without area and faces that repeat another are dropped, edges at which more than two faces meet are cut (Gueziec et
// al., Cutting and Stitching, 2001), one-sided sheets are cut where they contradict themselves, and vertices at which
// parts touch are split. What is cut lies as close as before, but is a border.
#pragma once

#include <array>
#include <cstdint>
#include <glm/vec3.hpp>
#include <vector>

#include "base/result.h"
#include "terrain/model/model.h"

namespace foreland::terrain {

using Triangle = std::array<uint32_t, 3>;  // vertices, counter-clockwise seen from outside

enum class OnDefect : uint8_t { kRefuse, kRepair };

struct Repairs {
  uint64_t repeated_corners = 0;  // dropped from faces that kept an area
  uint64_t degenerate_faces = 0, duplicate_faces = 0;
  uint64_t cut_edges = 0, split_vertices = 0;

  bool operator==(const Repairs&) const = default;
};

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
  Repairs repairs;
  std::vector<Triangle> degenerate;  // dropped faces without area, as the model's vertices; a line has corners twice
};

// Errors name the model's first offending face or vertex: a face whose outline crosses itself, a model without extent
// or without a face that has an area. With OnDefect::kRefuse also what would be repaired. The repair of a repaired
// model changes nothing and counts nothing. Cost: O(n log n).
[[nodiscard]] Result<Original> makeOriginal(const Model& model, OnDefect on_defect = OnDefect::kRefuse);

// The triangles with the orientation that the model's file gives them.
[[nodiscard]] std::vector<Triangle> facesAsGiven(const Original& original);

// The positions of the original's vertices in another pose of its model. Error, naming the pose's file, unless it has
// the same faces of the same vertices, and those that were welded lie together in it as well.
[[nodiscard]] Result<std::vector<glm::dvec3>> positionsInPose(const Original& original, const Model& model,
                                                              const Model& pose);

// The table of Original::twins for any triangles, or the first face that is the third at one of its edges.
struct Adjacency {
  std::vector<Triangle> twins;
  uint32_t non_manifold_face = kNoIndex;  // kNoIndex if every edge has at most two; else `twins` is incomplete
  uint32_t non_manifold_edge = 0;
};
[[nodiscard]] Adjacency findAdjacency(const std::vector<Triangle>& faces);

}  // namespace foreland::terrain
