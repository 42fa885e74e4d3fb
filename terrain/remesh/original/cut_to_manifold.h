// Which triangles are neighbours, if those of a model that is no manifold are to become one: where more than two meet
// at an edge, or neighbours contradict each other's orientation all around, they are parted. Pure; any thread.
#pragma once

#include <cstdint>
#include <vector>

#include "terrain/remesh/original/original.h"

namespace foreland::terrain {

struct ManifoldTwins {
  std::vector<Triangle> twins;  // as Original::twins
  uint64_t cut_edges = 0;       // that the model itself has, so not those that only welding made
};

// `faces` name welded vertices, `sources` the vertices of the model at the same corners. Two faces that share an edge
// of the model stay neighbours rather than two that only touch there. Every fan of the faces around a vertex must get a
// vertex of its own; then the twins are what findAdjacency finds, and the surface is orientable. If the model is a
// manifold already, the twins are findAdjacency's for `faces`. The same again, with those vertices as sources, gives
// the same twins and cuts nothing. Cost: O(n log n), as often as cutting an edge makes others non-manifold.
[[nodiscard]] ManifoldTwins cutToManifold(const std::vector<Triangle>& faces, const std::vector<Triangle>& sources);

}  // namespace foreland::terrain
