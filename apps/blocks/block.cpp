// foreland-block: makes blocks of a plan, each a file that is named by its content. Exit codes: 0 done, 2 anything
// else, with a line on stderr; nothing half-written stays.
#include <CLI/CLI.hpp>
#include <cstdio>
#include <filesystem>
#include <vector>

#include "apps/blocks/plan_file.h"
#include "apps/options/command_line.h"
#include "apps/options/options.h"
#include "terrain/pipeline/block_file.h"

namespace {

using namespace foreland;

int fail(const Error& error) {
  std::fprintf(stderr, "foreland block: %s\n", error.message.c_str());
  return 2;
}

Status makeBlock(const apps::OpenedPlan& opened, const terrain::Blocks& blocks, const proto::GeographicTables& tables,
                 uint64_t number, const std::filesystem::path& plan, const std::filesystem::path& folder) {
  const auto column = static_cast<uint32_t>(number % blocks.columns()),
             row = static_cast<uint32_t>(number / blocks.columns());
  const uint64_t id = opened.plan.ids[number];
  if (const auto kept = terrain::BlockFile::open(folder, blocks, column, row, id); kept && kept->points()) return {};
  const auto heights = terrain::readWindow(opened.ground(), blocks.withHalo(column, row));
  if (!heights) return heights.error();
  if (terrain::blockId(opened.plan, opened.source().info(), blocks, column, row, *heights) != id) {
    const auto epoch = apps::changedEpoch(plan);
    const std::string what = epoch && !epoch->empty() ? *epoch : opened.source().info().title;
    return Error{ErrorCode::kInvalidArgument, what + ": block " + std::to_string(number) + " has changed since " +
                                                  plan.string() + " was made; make the plan again with foreland plan"};
  }
  return terrain::writeBlock(folder, opened.plan, opened.source().info(), blocks, tables, column, row, id, *heights);
}

int run(const std::filesystem::path& plan, const std::vector<uint64_t>& numbers, const std::filesystem::path& folder) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) return fail({ErrorCode::kIo, folder.string() + ": cannot be made: " + error.message()});
  const auto opened = apps::openPlan(plan, apps::PlanUse::kBlock, {folder / "block"});
  if (!opened) return fail(opened.error());
  const auto grid = proto::GridTopology::create(opened->plan.shape);
  const terrain::Blocks blocks{*grid, opened->plan.block_log2};
  const proto::GeographicTables tables(proto::FrameTransform(opened->plan.frame), grid->maxX(), grid->maxY());
  for (const uint64_t number : numbers) {
    if (number >= blocks.count())
      return fail({ErrorCode::kInvalidArgument, "block " + std::to_string(number) + ": " + plan.string() +
                                                    " has the blocks 0 to " + std::to_string(blocks.count() - 1)});
    if (Status s = makeBlock(*opened, blocks, tables, number, plan, folder); !s.ok()) return fail(s.error());
  }
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{"Makes blocks of a plan. One that is there and whole is left as it is.", "foreland block"};
  std::filesystem::path plan, folder;
  std::vector<uint64_t> numbers;
  app.add_option("PLAN", plan, "what foreland plan wrote")->type_name(apps::file("PLAN.json"))->required();
  app.add_option("K", numbers, "which blocks of the plan, from 0 on")->type_name(apps::whole("K"))->required();
  app.add_option("-o,--output", folder, "the folder of the blocks' files")->type_name(apps::folder("DIR"))->required();
  const auto exit_code =
      apps::parseCommandLine(app, argc, argv, {{"the first block", "foreland block plan.json 0 -o blocks"}});
  if (exit_code) return *exit_code;
  return run(plan, numbers, folder);
}
