// A raster of any grid, resolution and reference system as heights on the lattice of a scene. Any thread may open; the
// source belongs to one thread at a time.
#pragma once

#include <filesystem>
#include <memory>

#include "base/result.h"
#include "terrain/dem/raster/open_options.h"
#include "terrain/elevation_source.h"

namespace foreland::terrain {

// The window of the lattice that the file reaches, by cubic interpolation of its samples; no data where it has none.
// What lies beyond the lattice is left out. All is read here. An Error names the file and the way out: it cannot be
// read, nothing relates its reference system to the lattice's, or it lies beyond it.
Result<std::unique_ptr<ElevationSource>> openOnLattice(const std::filesystem::path& file, const OpenOptions& options,
                                                       const ElevationInfo& lattice);

}  // namespace foreland::terrain
