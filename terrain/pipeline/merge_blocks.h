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

struct WindowedOptions {
  PlanOptions plan;
  std::filesystem::path output;
  unsigned threads = 0;
};

// Plan, blocks and merge in one go, in memory as PlanOptions has it. Blocks are kept in the folder "OUTPUT.blocks"
// until the scene is complete, so a build that was killed goes on where it was.
[[nodiscard]] Result<BuildReport> buildByBlocks(ElevationSource& source, const WindowedOptions& options,
                                                const Progress& progress = {});

// Makes those of the blocks [first, end) of a row whose files are not there yet. `heights` holds their halos.
Status makeBlocks(const BlockPlan& plan, const ElevationInfo& info, const Blocks& blocks,
                  const std::filesystem::path& folder, uint32_t row, uint32_t first, uint32_t end,
                  const HeightWindow& heights, unsigned threads);

}  // namespace foreland::terrain
