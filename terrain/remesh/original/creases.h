// Where a surface is sharp. Any thread.
#pragma once

#include <array>
#include <vector>

#include "terrain/remesh/original/original.h"

namespace foreland::terrain {

using EdgeFlags = std::vector<std::array<bool, 3>>;  // of each face's edges; the same from both sides

// Edges between faces whose normals' cosine is below `cosine`. Borders are not among them.
[[nodiscard]] EdgeFlags findCreases(const Original& surface, double cosine);

// Crease edges in a row, from one vertex where something happens (an end, a fork, a bend of more than 40 degrees) to
// the next, or around a loop: then the first vertex is also the last.
struct Chain {
  std::vector<uint32_t> vertices;
  std::vector<uint32_t> edges;  // from each vertex to the next, as 3 * face + edge
};
[[nodiscard]] std::vector<Chain> findChains(const Original& surface, const EdgeFlags& creases);

}  // namespace foreland::terrain
