// Opens elevation files of any kind as one ElevationSource: what GDAL reads, and OpenEXR height maps. Everything that
// had to be assumed about an input is a sentence in its notes; everything that cannot be meant is an Error that names
// the file and the way out. GDAL's own messages never reach the terminal. Any thread may open; the source belongs to
// one thread at a time.
#pragma once

#include <filesystem>
#include <memory>
#include <vector>

#include "base/result.h"
#include "terrain/dem/raster/open_options.h"
#include "terrain/elevation_source.h"

namespace foreland::terrain {

// Several inputs make a mosaic on the lattice of the first one; where they overlap, the first that has data counts.
Result<std::unique_ptr<ElevationSource>> openElevation(const std::vector<std::filesystem::path>& inputs,
                                                       const OpenOptions& options);

}  // namespace foreland::terrain
