// Where the creases of the original cross the edges of the lattice, found by mapping points of the creases to the
// coarse mesh. Any thread.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "terrain/remesh/lattice/lattice.h"
#include "terrain/remesh/original/creases.h"
#include "terrain/remesh/simplify/simplify.h"

namespace foreland::terrain {

// A crease crosses the lattice edge between two vertices, `fraction` of the way from the first to the second.
struct Crossing {
  std::array<uint32_t, 2> ends{};
  double fraction = 0;
  SurfacePoint point;  // on the original
};

class CrossingFinder {
 public:
  CrossingFinder(const Original& surface, const Base& base, const Lattice& lattice);

  LatticeCell cellOf(const SurfacePoint& on_original) const;
  // All crossings in order from the chain's start to its end. Precision: about 1e-5 of a crease edge's length.
  std::vector<Crossing> along(const Chain& chain) const;

 private:
  struct Tracer;

  const Original& surface_;
  const Base& base_;
  const Lattice& lattice_;
  std::vector<uint32_t> base_face_;  // by index in the map
};

}  // namespace foreland::terrain
