// The writers that createElevationFile (terrain/dem/write.h) chooses from.
#pragma once

#include <memory>

#include "base/result.h"
#include "terrain/dem/raster/elevation_writer.h"

namespace foreland::terrain {

Result<std::unique_ptr<ElevationWriter>> createExr(const ElevationFile& file);
Result<std::unique_ptr<ElevationWriter>> createTiff(const ElevationFile& file);

}  // namespace foreland::terrain
