// Simplifies a surface to about as many triangles as asked, by taking out one vertex after the other (into a neighbour,
// so base vertices are vertices of the original), cheapest first by quadric error, and keeps the map between the two.
// Vertices on the border leave it only along it; creases cost what their loss would do to the shape, and a vertex taken
// out along its crease leaves it a crease. The topology stays: closed stays closed, a hole stays a hole.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "terrain/remesh/original/creases.h"
#include "terrain/remesh/original/original.h"
#include "terrain/remesh/simplify/coarse_map.h"

namespace foreland::terrain {

struct Base {
  std::vector<uint32_t> vertices;  // the original's vertex that each is
  std::vector<Triangle> faces;     // of `vertices`
  std::vector<uint32_t> numbers;   // what the map calls each face
  CoarseMap map;
  std::vector<Chain> courses;  // base edges that run along a border or crease of the original, from end to end
};

struct SimplifyOptions {
  uint32_t target_faces = 200;
  double crease_cosine = 0.766;          // normals further apart than 40 degrees make a crease
  std::span<const double> importance{};  // of each vertex: how many times its surroundings' errors count; empty: once
};

// May stop above the target where nothing more can go without changing the topology or folding the surface. One thread;
// the same result everywhere. Cost: n log n.
[[nodiscard]] Base simplify(const Original& original, const SimplifyOptions& options);

}  // namespace foreland::terrain
