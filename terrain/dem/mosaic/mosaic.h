// Several rasters on one lattice. None is resampled: each keeps its own samples, so tiles that meet in a seam share the
// samples on it. Pure functions.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "base/result.h"
#include "terrain/dem/raster/raster.h"

namespace foreland::terrain {

struct Tile {
  std::unique_ptr<Raster> raster;
  Georeference map;              // resolved (placement.h)
  uint32_t column = 0, row = 0;  // of its first sample in the mosaic
  std::string input{};           // the file as it was opened, which may have several rasters
  std::string vertical{};        // what its heights counted from, if that is stated
  double off_lattice = 0;        // how far its samples were from the mosaic's, in samples
};

struct Mosaic {
  std::vector<Tile> tiles;
  Georeference map;  // of the whole
  uint32_t width = 0, height = 0;
  std::vector<std::string> notes;
};

// Whether a tile's samples are those of the first one's lattice, or shifted by less than one alike: makeMosaic takes
// it.
bool isOnOneLattice(const Tile& first, const Tile& tile);

// Whether tiles of one lattice overlap, or lie side by side.
bool touch(const Tile& a, const Tile& b);

// The lattice is that of the first tile. Error, naming both files, for tiles of different reference systems or
// resolutions.
Result<Mosaic> makeMosaic(std::vector<Tile> tiles);

}  // namespace foreland::terrain
