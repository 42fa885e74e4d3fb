// The file of a plan, plan.json: what foreland plan found out about elevation, with the words that say how it is read
// and what the scene has beside it, and the list of blocks. foreland block opens the elevation again by it, foreland
// merge pictures and models, too. Main thread.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "apps/build/elevation_options.h"
#include "apps/build/epoch_options.h"
#include "apps/build/scene_options.h"
#include "apps/options/foreign_files.h"
#include "base/result.h"
#include "terrain/elevation_source.h"
#include "terrain/pipeline/block_plan.h"
#include "terrain/pipeline/merge_blocks.h"

namespace foreland::apps {

struct PlanArguments {
  ElevationArguments elevation;
  EpochArguments epochs;
  SceneArguments scene;
  ForeignFiles foreign;
};
void describePlanned(CLI::App& app, PlanArguments& arguments);

// The words of describePlanned() that a command line has.
std::vector<std::string> plannedWords(const CLI::App& app);

// All files that the words name, for reading. Some may not be there.
std::vector<std::filesystem::path> filesOf(const PlanArguments& arguments);

// The file of an epoch that is not what the plan was made of; nothing if they all are. Reads all of them.
Result<std::string> changedEpoch(const std::filesystem::path& plan);

Status writePlan(const std::filesystem::path& path, const std::vector<std::string>& words,
                 const PlanArguments& arguments, const terrain::BlockPlan& plan);

// What a plan's voids are filled with is in a file whose name begins with this.
std::filesystem::path voidsBeside(const std::filesystem::path& plan);

// Blocks are made of heights alone, with what voids are filled with; a merge reads no heights, but pictures and models.
enum class PlanUse : uint8_t { kBlock, kMerge };

struct OpenedPlan {
  terrain::BlockPlan plan;
  OpenedGround input;    // for kMerge without the files of its epochs
  OpenedAdditions with;  // for kMerge alone
  terrain::ElevationSource& source() const { return *input.source; }
  terrain::GroundInTime ground() const { return {source(), input.epochs, plan.voids}; }
};
// Opens a plan and the inputs that its use needs, and confines the process to them and to the folders of `outputs`. An
// Error says what of the plan is damaged, or which file is another one than it was: of elevation the blocks' names
// tell more than the size.
Result<OpenedPlan> openPlan(const std::filesystem::path& path, PlanUse use,
                            const std::vector<std::filesystem::path>& outputs);

}  // namespace foreland::apps
