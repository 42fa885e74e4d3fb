// Elevation files that GDAL reads, archives included. GDAL's messages become part of our errors and notes. One owner,
// one thread.
#pragma once

#include <filesystem>
#include <memory>
#include <vector>

#include "base/result.h"
#include "terrain/dem/raster/open_options.h"
#include "terrain/dem/raster/raster.h"

namespace foreland::terrain {

// Registers GDAL's drivers on the first call; later calls do nothing. Any thread. Those that open connections, and all
// file systems but archives, are left out (gdal_files.h), unless a test of what else holds wants them: `all`.
void registerGdalDrivers(bool all = false);

// The one raster of a file, or all rasters in an archive (.zip). Each has been surveyed and has at least one height.
Result<std::vector<std::unique_ptr<Raster>>> openGdalRasters(const std::filesystem::path& path,
                                                             const OpenOptions& options);

}  // namespace foreland::terrain
