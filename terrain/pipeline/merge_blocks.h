// The reduction of a plan's blocks to a scene file: what they share, what is coarser than all of them, relief, and the
// file, the same bytes that buildScene() writes of the source. One caller; uses threads of its own while it runs.
//
// Memory: about a sixteenth of a byte a sample, a kilobyte for each column of the lattice, ten bytes for each sample of
// a block and each thread, and what pictures (terrain/imagery/imagery.h), coded pages and models take. For each epoch
// another 64th of a byte a sample, an eighth where its ground is not the first one's, and 132 bytes a column there.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "base/result.h"
#include "terrain/pipeline/block_plan.h"
#include "terrain/pipeline/build.h"

namespace foreland::terrain {

// An Error names the object that cannot stand on the ground, or whose poses are at dates that are not the plan's. Of
// heights nothing is asked, so it may come before blocks.
[[nodiscard]] Status checkAdditions(const ElevationInfo& ground, const std::vector<EpochRequest>& epochs,
                                    proto::EpochBlend blend, const SceneAdditions& additions);

struct MergeOptions {
  std::filesystem::path blocks;  // the folder of their files
  std::filesystem::path output;
  unsigned threads = 0;  // 0: one per processor
  SceneAdditions additions{};
};

// An Error names the block that is missing, damaged or another one.
[[nodiscard]] Result<BuildReport> mergeBlocks(const ElevationSource& source, const BlockPlan& plan,
                                              const MergeOptions& options, const Progress& progress = {});

}  // namespace foreland::terrain
