// Relaxes the lattice on the surface: vertices move over the surface to where the triangles around them have the best
// shape, and never to where one of them would fold. The energy measures how far each triangle is from an equilateral
// one of its base face's mean size, with a penalty that grows without bound as the triangle flips (Garanzha et al.,
// "Foldover-free maps in 50 lines of code", 2021, equations 2 to 4).
#pragma once

#include "terrain/remesh/lattice/embedding.h"
#include "terrain/remesh/lattice/lattice.h"
#include "terrain/remesh/original/creases.h"

namespace foreland::terrain {

struct RelaxOptions {
  int rounds = 20;
  unsigned threads = 0;
};

// Vertices on a curve slide along it, fixed ones stay, and free ones do not cross creases. The result does not depend
// on the number of threads. Cost: about 3 us per vertex and round.
void relax(const Original& surface, const EdgeFlags& creases, const Lattice& lattice, const RelaxOptions& options,
           Embedding& embedding);

}  // namespace foreland::terrain
