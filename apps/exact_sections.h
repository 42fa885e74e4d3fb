// The section computed exactly for a pose (as it travels, rounded to the millimetre, so that a known path has no
// extrapolation error), as a mesh: what the error terms of DESIGN section 4 compare with. Here the program introduces
// the oracle, which must not know the refiner, to the refiner. One owner.
#pragma once

#include <memory>

#include "bench/oracle/flight_truth.h"
#include "terrain/store/scene.h"

namespace foreland::apps {

bench::SectionAt exactSections(std::shared_ptr<const terrain::Scene> scene);

}  // namespace foreland::apps
