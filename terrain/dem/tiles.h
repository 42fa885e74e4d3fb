// Opens elevation files of any kind, each with its place on a map. Any thread may open; a tile belongs to one at a
// time.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "base/result.h"
#include "terrain/dem/mosaic/mosaic.h"
#include "terrain/dem/raster/open_options.h"

namespace foreland::terrain {

// Every raster of every input with its map resolved, all turned alike. Adds what had to be assumed about each file to
// `notes`. An Error names the file and the way out.
Result<std::vector<Tile>> openTiles(const std::vector<std::filesystem::path>& inputs, const OpenOptions& options,
                                    std::vector<std::string>& notes);

}  // namespace foreland::terrain
