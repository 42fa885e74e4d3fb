// Sharp edges of a surface, and the chains that they form. Pure; any thread.
#pragma once

#include <array>
#include <vector>

#include "terrain/remesh/original/original.h"

namespace foreland::terrain {

using EdgeFlags = std::vector<std::array<bool, 3>>;  // of each face's edges; both sides of an edge agree

// Flags the edges between faces whose normals have a dot product below `cosine`. Border edges are not flagged.
[[nodiscard]] EdgeFlags findCreases(const Original& surface, double cosine);

// Consecutive crease edges between two feature vertices (where a crease ends, forks, or bends by more than 40 degrees),
// or around a loop: then the first vertex is also the last.
struct Chain {
  std::vector<uint32_t> vertices;
  std::vector<uint32_t> edges;  // from each vertex to the next, as 3 * face + edge
};
[[nodiscard]] std::vector<Chain> findChains(const Original& surface, const EdgeFlags& creases);

}  // namespace foreland::terrain
