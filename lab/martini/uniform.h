// What it takes to compare a view-dependent refiner with one that knows only an error in metres. Pure; any thread.
#pragma once

#include <optional>

#include "proto/refine/metric/metric.h"
#include "proto/section/section.h"
#include "server/section/hierarchy.h"

namespace foreland::lab {

// A view that sees all of the terrain and asks for the same error in metres (to 1 %) everywhere: from so far above that
// the terrain is a small spot. Errors must count as seen from any side, so `hierarchy` is of ErrorBound::kSphere.
proto::View uniformView(const server::Hierarchy& hierarchy, double max_error_m);

// The smallest error in metres that `view` asks for anywhere in its frustum: tau at the depth of the nearest node in
// view.
double nearestError_m(const server::Hierarchy& hierarchy, const proto::View& view);

// Largest difference in height between the section's surface and the samples; by the definition of a section's surface
// (THEORY section 2), node by node, with nothing of the refiner's. Nothing for terrains of more than 2^25 samples: it
// takes 8 bytes each.
std::optional<double> trueError_m(const terrain::Scene& scene, const proto::Section& section);

}  // namespace foreland::lab
