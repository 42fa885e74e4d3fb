// foreland-merge: makes the scene file of a plan's blocks. Exit codes: 0 done, 2 anything else, with a line on stderr;
// nothing half-written stays.
#include <CLI/CLI.hpp>
#include <chrono>
#include <cstdio>
#include <filesystem>

#include "apps/blocks/plan_file.h"
#include "apps/build/scene_report.h"
#include "apps/options/command_line.h"
#include "apps/options/options.h"
#include "apps/options/output_file.h"
#include "apps/report/progress_line.h"
#include "apps/stop_signal.h"
#include "terrain/pipeline/merge_blocks.h"

namespace {

using namespace foreland;
using Clock = std::chrono::steady_clock;

int fail(const Error& error) {
  std::fprintf(stderr, "foreland merge: %s\n", error.message.c_str());
  return 2;
}

int merge(const std::filesystem::path& plan, terrain::MergeOptions options) {
  const Clock::time_point begun = Clock::now();
  if (Status s = apps::checkOutput(options.output, "scene file"); !s.ok()) return fail(s.error());
  const auto opened = apps::openPlan(plan, apps::PlanUse::kMerge, {options.output, options.blocks / "block"});
  if (!opened) return fail(opened.error());
  options.additions = opened->with.additions;
  apps::ProgressLine line;
  const auto built =
      terrain::mergeBlocks(opened->source(), opened->plan, options,
                           {.report = [&](std::string_view stage, double done) { line.show(stage, done); },
                            .keepGoing = [] { return !apps::isStopRequested(); }});
  line.end();
  if (!built) return fail(built.error());
  apps::printScene(*built, options.output, std::chrono::duration<double>(Clock::now() - begun).count());
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{"Makes the scene file of a plan's blocks, the one that foreland build makes of its inputs.",
               "foreland merge"};
  std::filesystem::path plan;
  terrain::MergeOptions options;
  app.add_option("PLAN", plan, "what foreland plan wrote")->type_name(apps::file("PLAN.json"))->required();
  app.add_option("DIR", options.blocks, "the folder of the blocks' files")->type_name(apps::folder("DIR"))->required();
  app.add_option("-o,--output", options.output, "the scene file to write")
      ->type_name(apps::file("SCENE.fls"))
      ->required();
  app.add_option("--threads", options.threads, "worker threads; 0 for one per processor")
      ->type_name(apps::whole("N"))
      ->check(apps::within(0u, 1024u))
      ->capture_default_str();
  const auto exit_code =
      apps::parseCommandLine(app, argc, argv, {{"", "foreland merge plan.json blocks -o scene.fls"}});
  if (exit_code) return *exit_code;
  apps::catchStopSignals();
  return merge(plan, options);
}
