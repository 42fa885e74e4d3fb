// A raster whose heights are counted from another surface. One owner, one thread.
#pragma once

#include <memory>

#include "terrain/dem/raster/raster.h"
#include "terrain/dem/vertical/height_reference.h"
#include "terrain/dem/vertical/map_places.h"

namespace foreland::terrain {

// Heights above `to` instead of above `from`, sample by sample: H + N of the one, less N of the other. Both have
// undulations, or are the ellipsoid. A row is an Error where a grid has no undulation for one of its heights. Costs a
// transformation by PROJ for each sample and geoid.
std::unique_ptr<Raster> shiftedRaster(std::unique_ptr<Raster> inner, MapPlaces places, HeightReference from,
                                      HeightReference to);

}  // namespace foreland::terrain
