// From a surface to its remesh: a base mesh, and the true position of every vertex of the base's quadrisection lattice.
//
// The vertices lie on the original surface: base vertices at some of its vertices, borders on its borders, and where it
// has creases (normals more than 40 degrees apart), lattice edges follow them. The parametrisation is carried through
// the simplification (simplify/coarse_map.h), so it is one to one and cannot jump between parts that lie near each
// other; then the lattice is snapped to the creases (lattice/embedding.h) and relaxed on the surface (lattice/relax.h).
//
// Several attempts are made: where one lies furthest from the original, or folds, the next one's base mesh gets more
// triangles (importance.h). The best attempt is the result.
#pragma once

#include <cstdint>
#include <functional>
#include <glm/vec3.hpp>
#include <vector>

#include "base/result.h"
#include "terrain/remesh/lattice/lattice.h"
#include "terrain/remesh/original/original.h"
#include "terrain/remesh/original/surface_point.h"

namespace foreland::terrain {

struct RemeshOptions {
  uint32_t base_triangles = 200;
  int levels = 4;
  int attempts = 12;
  int relax_rounds = 10;
  unsigned threads = 0;                                                    // 0: one per processor
  std::function<bool(int attempt)> keep_going = [](int) { return true; };  // false: return the best attempt so far
};

struct Remeshed {
  std::vector<glm::dvec3> base_vertices;
  std::vector<Triangle> base_faces;
  Lattice lattice;
  std::vector<SurfacePoint> points;   // of every lattice vertex: where it lies on the original
  std::vector<glm::dvec3> positions;  // the same points in space
};

// The positions of the same vertices in another pose of the original: `positions` of its vertices.
[[nodiscard]] Remeshed posedAs(const Remeshed& remeshed, const Original& original,
                               const std::vector<glm::dvec3>& positions);

inline constexpr uint64_t kMaxLatticeVertices = 1u << 27;

// The base may have more triangles than asked for, where the topology or the borders need them. Error: more than
// kMaxLatticeVertices. The result does not depend on the number of threads. Cost: an attempt takes about 20 us per
// vertex of the original and per vertex of the lattice.
[[nodiscard]] Result<Remeshed> remesh(const Original& original, const RemeshOptions& options);

}  // namespace foreland::terrain
