// The formats behind createElevationFile. See write.h.
#pragma once

#include <memory>

#include "terrain/dem/write.h"

namespace foreland::terrain {

Result<std::unique_ptr<ElevationWriter>> createExr(const ElevationFile& file);
Result<std::unique_ptr<ElevationWriter>> createTiff(const ElevationFile& file);

}  // namespace foreland::terrain
