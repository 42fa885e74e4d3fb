// OpenEXR height maps, through OpenEXR itself: half, float or integer samples, metres, top image row is north. One
// owner, one thread.
#pragma once

#include <filesystem>
#include <memory>

#include "base/result.h"
#include "terrain/dem/raster/open_options.h"
#include "terrain/dem/raster/raster.h"

namespace foreland::terrain {

// Attribute (float or double) that states the metres between samples; --spacing overrides it.
inline constexpr const char* kExrSpacingAttribute = "spacing_m";

bool isExrFile(const std::filesystem::path& path);  // by its first bytes

Result<std::unique_ptr<Raster>> openExrRaster(const std::filesystem::path& path, const OpenOptions& options);

}  // namespace foreland::terrain
