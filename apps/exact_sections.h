// The section computed exactly for a pose, as a mesh: what the error terms of THEORY section 4 are measured against.
// The pose is rounded to the millimetre as on the wire, so that a known path has no extrapolation error. The oracle
// calls the refiner through these functions, for it must not know the refiner's code.
#pragma once

#include <functional>
#include <memory>

#include "oracle/section_at.h"
#include "server/section/hierarchy.h"
#include "terrain/store/scene.h"

namespace foreland::apps {

// Makes one for each thread; they share what does not change.
std::function<oracle::SectionAt()> exactSectionsOf(std::shared_ptr<const terrain::Scene> scene,
                                                   server::SceneObjects objects = {});

// One of these. Of the terrain, and of `objects` if they are given (server::objectsOf).
oracle::SectionAt exactSections(std::shared_ptr<const terrain::Scene> scene, server::SceneObjects objects = {});

}  // namespace foreland::apps
