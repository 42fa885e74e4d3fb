// The scene of an elevation source whose lattice is fine in places only. One caller; uses threads of its own while it
// runs.
#pragma once

#include "base/result.h"
#include "terrain/elevation_source.h"
#include "terrain/pipeline/build.h"

namespace foreland::terrain {

// As buildScene() does it of a lattice that is whole; source.sparse() is not null. The residuals that the scene states
// are those of its own surface. An Error names what such a scene cannot have: epochs.
[[nodiscard]] Result<BuildReport> buildSparseScene(const ElevationSource& source, const BuildOptions& options,
                                                   const Progress& progress);

}  // namespace foreland::terrain
