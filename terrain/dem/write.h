// Creates elevation files that openElevation reads back. A file appears under its name whole or not at all.
#pragma once

#include <memory>

#include "base/result.h"
#include "terrain/dem/raster/elevation_writer.h"

namespace foreland::terrain {

// The suffix of the path chooses the format. The writer belongs to the caller, one thread at a time.
Result<std::unique_ptr<ElevationWriter>> createElevationFile(const ElevationFile& file);

}  // namespace foreland::terrain
