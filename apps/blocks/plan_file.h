// The file of a plan, plan.json: what foreland plan found out about elevation, with the words that say how it is read,
// and the list of blocks. foreland block and foreland merge open the inputs again by it. Main thread.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "apps/build/elevation_options.h"
#include "apps/options/foreign_files.h"
#include "base/result.h"
#include "terrain/elevation_source.h"
#include "terrain/pipeline/block_plan.h"

namespace foreland::apps {

struct PlanArguments {
  ElevationArguments elevation;
  ForeignFiles foreign;
};
void describePlanned(CLI::App& app, PlanArguments& arguments);

// The words of describePlanned() that a command line has.
std::vector<std::string> plannedWords(const CLI::App& app);

Status writePlan(const std::filesystem::path& path, const std::vector<std::string>& words,
                 const PlanArguments& arguments, const terrain::BlockPlan& plan);

// What a plan's voids are filled with is in a file whose name begins with this.
std::filesystem::path voidsBeside(const std::filesystem::path& plan);

// Whether heights are read, or only what is known of them: the first needs what voids are filled with.
enum class PlanUse : uint8_t { kHeights, kInfo };

struct OpenedPlan {
  terrain::BlockPlan plan;
  std::unique_ptr<terrain::ElevationSource> input;
  std::unique_ptr<terrain::ElevationSource> filled;  // the input without voids; null if it has none, or for kInfo
  terrain::ElevationSource& source() const { return filled ? *filled : *input; }
};
// Opens a plan and its inputs, and confines the process to them and to the folders of `outputs`. An Error says what of
// the plan is damaged, or which file is another one than it was.
Result<OpenedPlan> openPlan(const std::filesystem::path& path, const std::vector<std::filesystem::path>& outputs,
                            PlanUse use);

}  // namespace foreland::apps
