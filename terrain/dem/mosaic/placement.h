// From georeferences to the scene frame: which of rows and columns to reverse, so that the lattice counts eastward and
// northward and is right-handed, and how its axes lie in metres. Pure functions; no file format here.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "base/result.h"
#include "proto/space/frame.h"
#include "terrain/dem/raster/open_options.h"
#include "terrain/dem/raster/raster.h"

namespace foreland::terrain {

struct Extent {
  std::string name;  // of the input, for messages
  uint32_t width = 0, height = 0;
  float lowest_m = 0, highest_m = 0;
};

struct RasterPlacement {
  proto::Frame frame;
  bool is_column_reversed = false;  // lattice x = width - 1 - column
  bool is_row_reversed = true;      // lattice y = height - 1 - row, as image rows count from the top
  std::vector<std::string> notes;
};

// Decides by the numbers and the options what coordinates without a reference system mean: degrees, metres, or no
// position at all. Adds what was assumed to `notes`.
Result<Georeference> resolveMap(const Georeference& stated, const Extent& extent, const OpenOptions& options,
                                std::vector<std::string>& notes);

// `resolved` comes from resolveMap, with the transform of the whole mosaic.
Result<RasterPlacement> placeRaster(const Georeference& resolved, const Extent& extent, const OpenOptions& options);

}  // namespace foreland::terrain
