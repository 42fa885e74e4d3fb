// A mosaic as an ElevationSource: the first tile that has data at a sample counts. One owner, one thread at a time.
#pragma once

#include <memory>

#include "terrain/dem/mosaic/mosaic.h"
#include "terrain/dem/mosaic/placement.h"
#include "terrain/elevation_source.h"

namespace foreland::terrain {

// `info` is what the source says of itself. Tiles that disagree where they overlap are warnings, once rows were read.
std::unique_ptr<ElevationSource> mosaicSource(Mosaic mosaic, const RasterPlacement& placement, ElevationInfo info);

}  // namespace foreland::terrain
