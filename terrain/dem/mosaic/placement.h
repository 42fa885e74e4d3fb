// From what files say about their place to the scene frame: which rows and columns to turn around so that the lattice
// counts eastward and northward and is right-handed, and where its axes lie in metres. Pure functions; no file format
// here.
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

struct Placement {
  proto::Frame frame;
  bool is_column_reversed = false;  // lattice x = width - 1 - column
  bool is_row_reversed = true;      // lattice y = height - 1 - row, as image rows count from the top
  std::vector<std::string> notes;
};

// Settles what an input without a reference system means (degrees, metres, nothing) by its numbers and the options.
Result<Georeference> settleMap(const Georeference& said, const Extent& extent, const OpenOptions& options,
                               std::vector<std::string>& notes);

// `settled` comes from settleMap; the transform is that of the whole mosaic.
Result<Placement> placeRaster(const Georeference& settled, const Extent& extent, const OpenOptions& options);

}  // namespace foreland::terrain
