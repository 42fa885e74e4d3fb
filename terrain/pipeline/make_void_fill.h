// Finds out what the voids of a source are to be filled with, row by row: the heights that fillVoids() gives. Memory:
// some rows, and 20 bytes for each run of voids; the pyramid waits in a temporary file, 4/3 bytes a sample. One caller.
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <span>

#include "base/result.h"
#include "terrain/elevation_source.h"
#include "terrain/pipeline/build.h"
#include "terrain/pipeline/void_fill.h"

namespace foreland::terrain {

struct FilledVoids {
  VoidReport report;
  std::shared_ptr<const VoidFill> fill;
};

// The file is named PREFIX, its id and ".voids"; one that is there and whole is taken. `see` gets all rows as they are,
// once. There must be voids. An Error: there is nothing else; or the source changes while it is read.
Result<FilledVoids> makeVoidFill(ElevationSource& source, const std::filesystem::path& prefix,
                                 const std::function<void(std::span<const float> row)>& see, const Progress& progress);

}  // namespace foreland::terrain
