// The reduction of a plan's blocks to a scene file: what they share, what is coarser than all of them, relief, and the
// file, the same bytes that buildScene() writes of the source. One caller; uses threads of its own while it runs.
//
// Memory: about a sixteenth of a byte a sample, a kilobyte for each column of the lattice, and ten bytes for each
// sample of a block and each thread.
#pragma once

#include <filesystem>

#include "base/result.h"
#include "terrain/pipeline/block_plan.h"
#include "terrain/pipeline/build.h"

namespace foreland::terrain {

struct MergeOptions {
  std::filesystem::path blocks;  // the folder of their files
  std::filesystem::path output;
  unsigned threads = 0;  // 0: one per processor
};

// An Error names the block that is missing, damaged or another one.
[[nodiscard]] Result<BuildReport> mergeBlocks(const ElevationSource& source, const BlockPlan& plan,
                                              const MergeOptions& options, const Progress& progress = {});

}  // namespace foreland::terrain
