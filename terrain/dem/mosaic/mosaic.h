// Several rasters on one lattice. Each keeps its own samples: none is resampled, so tiles that share a seam share its
// very samples. Pure functions.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "base/result.h"
#include "terrain/dem/raster/raster.h"

namespace foreland::terrain {

struct Tile {
  std::unique_ptr<Raster> raster;
  Georeference map;              // settled
  uint32_t column = 0, row = 0;  // of its first sample in the mosaic
};

struct Mosaic {
  std::vector<Tile> tiles;
  Georeference map;  // of the whole
  uint32_t width = 0, height = 0;
  std::vector<std::string> notes;
};

// Every tile's map is settled. Refuses tiles of different reference systems or resolutions, naming both files.
Result<Mosaic> layMosaic(std::vector<Tile> tiles);

}  // namespace foreland::terrain
