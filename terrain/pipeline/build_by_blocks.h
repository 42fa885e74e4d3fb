// A scene that is made block by block in one process: plan, blocks and merge in one go. One caller; uses threads of its
// own while it runs.
#pragma once

#include <filesystem>

#include "base/result.h"
#include "terrain/pipeline/block_plan.h"
#include "terrain/pipeline/build.h"
#include "terrain/pipeline/merge_blocks.h"

namespace foreland::terrain {

struct WindowedOptions {
  PlanOptions plan;  // its voids wait with the blocks
  std::filesystem::path output;
  unsigned threads = 0;
  SceneAdditions additions{};
};

// In memory as PlanOptions has it, and as merge_blocks.h says. Blocks are kept in the folder "OUTPUT.blocks"
// until the scene is complete, so a build that was killed goes on where it was.
[[nodiscard]] Result<BuildReport> buildByBlocks(ElevationSource& source, const WindowedOptions& options,
                                                const Progress& progress = {});

}  // namespace foreland::terrain
