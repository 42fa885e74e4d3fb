// The surface of a remesh, by either rule of refinement: positions become whole steps. Pure; any thread.
#pragma once

#include <vector>

#include "base/result.h"
#include "terrain/remesh/remesh.h"
#include "terrain/surface/surface.h"

namespace foreland::terrain {

// A power of two, about a millionth of the diagonal: positions move by at most 0.9 millionths of it.
[[nodiscard]] double defaultStep(const std::vector<glm::dvec3>& positions);

// Whether positions can be so many steps; to be asked before the work is done.
[[nodiscard]] Status checkStep(const std::vector<glm::dvec3>& positions, double step_m);

// By quadrisection nodes are the lattice's vertices. By bisection, which cuts each edge as often, they lie where the
// full mesh has their parameters: it follows the creases, as the original between its vertices would not. Error: what
// MeshTopology and makeSurface refuse.
[[nodiscard]] Result<TrueSurface> surfaceOf(const Remeshed& remeshed, proto::MeshRule rule, double step_m);

}  // namespace foreland::terrain
