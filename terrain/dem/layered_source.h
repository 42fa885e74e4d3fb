// Elevation of different grids as one source: a mosaic, and over and under it rasters of any grid, resolution and
// reference system. One thread.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "base/result.h"
#include "terrain/dem/datum.h"
#include "terrain/dem/mosaic/mosaic.h"
#include "terrain/dem/raster/open_options.h"
#include "terrain/elevation_source.h"

namespace foreland::terrain {

struct LaidTile {
  Tile tile;
  std::optional<int> priority;  // of an inset; none: an input that is not on the mosaic's lattice
};

// The lattice is the base's, over all inputs, halved until it is as fine as the finest tile, or as residual_m asks.
// Over the base lie insets, by priority and then in their order, and under these finer inputs in theirs; what is
// coarser than the base lies under it. Tiles of one grid and priority are one layer, without a seam. All is read here,
// so it takes the time and memory of that. An Error names the file and the way out: an inset that lies beyond the base,
// reference systems that nothing relates, more samples than a scene holds.
Result<std::unique_ptr<ElevationSource>> layeredSource(Mosaic base, std::vector<LaidTile> tiles,
                                                       const OpenOptions& options, const std::optional<Datum>& datum,
                                                       std::vector<std::string> notes);

}  // namespace foreland::terrain
