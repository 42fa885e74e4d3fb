// The surface of a remesh, by either rule of refinement: positions become whole steps. Pure; any thread.
#pragma once

#include <vector>

#include "base/result.h"
#include "terrain/remesh/remesh.h"
#include "terrain/surface/surface.h"

namespace foreland::terrain {

// The smallest step that is taken unasked: a power of two, about a millionth of the diagonal.
[[nodiscard]] double finestStep(const std::vector<glm::dvec3>& positions);

// The largest power of two that is at most a sixteenth of what the finest level's nodes typically (in the median) stand
// off the middle of their edges, so that positions move by less than a sixteenth of what the surface leaves out; finer
// steps would cost bits on the wire and say nothing. Never below finestStep, and at most 2^7 of these, for a step is
// never to be seen. O(lattice).
[[nodiscard]] double defaultStep(const Remeshed& remeshed);

// Whether positions can be so many steps.
[[nodiscard]] Status checkStep(const std::vector<glm::dvec3>& positions, double step_m);

// By quadrisection nodes are the lattice's vertices. By bisection, which cuts each edge as often, they lie where the
// full mesh has their parameters: it follows the creases, as the original between its vertices would not. Error: what
// MeshTopology and makeSurface refuse.
[[nodiscard]] Result<TrueSurface> surfaceOf(const Remeshed& remeshed, proto::MeshRule rule, double step_m);

}  // namespace foreland::terrain
