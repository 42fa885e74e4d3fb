// Sections computed exactly for one view after another, as meshes. Each is adapted from the one before, which gives the
// same section as refinement from scratch (the law of proto/refine/adapter.h) in a fifth of the time. The mesh spans
// both sections; draw it at weight 1. One owner.
#pragma once

#include <memory>

#include "oracle/flight_truth.h"
#include "server/session/world.h"

namespace foreland::lab {

// The scene of `world` outlives the chain. Of the terrain alone.
oracle::SectionAt sectionChain(std::shared_ptr<const server::World> world);

}  // namespace foreland::lab
