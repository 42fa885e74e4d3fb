// The files that a source is made of, before they are related to each other. One thread.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "base/result.h"
#include "terrain/dem/datum.h"
#include "terrain/dem/layered_source.h"
#include "terrain/dem/mosaic/mosaic.h"
#include "terrain/dem/raster/open_options.h"

namespace foreland::terrain {

struct OpenedInputs {
  Mosaic base;                   // the inputs on the lattice of the first one
  std::vector<LaidTile> others;  // other inputs, then insets, in their order
  std::optional<Datum> datum;    // what all heights count from, if anything is stated
  std::vector<std::string> notes;
};

// An Error names the file and the way out.
Result<OpenedInputs> openInputs(const std::vector<std::filesystem::path>& inputs, const OpenOptions& options);

}  // namespace foreland::terrain
