// Elevation files that GDAL reads, archives included. Every GDAL message is caught and folded into ours. One owner, one
// thread.
#pragma once

#include <filesystem>
#include <memory>
#include <vector>

#include "base/result.h"
#include "terrain/dem/raster/open_options.h"
#include "terrain/dem/raster/raster.h"

namespace foreland::terrain {

// Once per process, by whoever uses GDAL first.
void registerGdalDrivers();

// One raster, or all that an archive (.zip) holds. Each has been surveyed and has at least one height.
Result<std::vector<std::unique_ptr<Raster>>> openGdalRasters(const std::filesystem::path& path,
                                                             const OpenOptions& options);

}  // namespace foreland::terrain
