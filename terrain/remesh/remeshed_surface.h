// A remesh as a surface under either rule of refinement, its positions quantised. Pure; any thread.
#pragma once

#include <vector>

#include "base/result.h"
#include "terrain/remesh/remesh.h"
#include "terrain/surface/surface.h"

namespace foreland::terrain {

// The finest quantum chosen by default: a power of two, about a millionth of the bounding box's diagonal, but coarse
// enough for a surface to hold every coordinate.
[[nodiscard]] double finestQuantum(const std::vector<glm::dvec3>& positions);

// The largest power of two that is at most a sixteenth of the median displacement of the finest level's nodes, so
// quantising moves positions by less than a sixteenth of what the finest level adds; a finer quantum would cost bits on
// the wire for nothing. At least finestQuantum, and at most 2^7 times that, so that it is never visible. Cost:
// O(lattice).
[[nodiscard]] double defaultQuantum(const Remeshed& remeshed);

// Error if a coordinate is more quanta than a surface can hold (kMaxQuanta).
[[nodiscard]] Status checkQuantum(const std::vector<glm::dvec3>& positions, double quantum_m);

// Under quadrisection nodes are the lattice's vertices. Under bisection, which halves each edge as often, a node lies
// where the full mesh has its parameter: unlike the original between lattice vertices, the mesh follows the creases.
// Errors are those of MeshTopology and makeSurface.
[[nodiscard]] Result<TrueSurface> toSurface(const Remeshed& remeshed, proto::MeshRule rule, double quantum_m);

}  // namespace foreland::terrain
