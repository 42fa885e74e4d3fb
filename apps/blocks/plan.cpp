// foreland-plan: looks at elevation once and writes the list of blocks that make a scene of it. Exit codes: 0 done, 2
// anything else, with a line on stderr.
#include <CLI/CLI.hpp>
#include <cstdio>
#include <filesystem>

#include "apps/blocks/plan_file.h"
#include "apps/options/command_line.h"
#include "apps/options/options.h"
#include "apps/options/output_file.h"
#include "apps/options/toml_config.h"
#include "apps/report/progress_line.h"
#include "apps/stop_signal.h"
#include "terrain/dem/open.h"

namespace {

using namespace foreland;

struct Arguments {
  apps::PlanArguments planned;
  std::filesystem::path output;
  unsigned memory_mib = 1024;
};

int fail(const Error& error) {
  std::fprintf(stderr, "foreland plan: %s\n", error.message.c_str());
  return 2;
}

int plan(const Arguments& arguments, const std::vector<std::string>& words) {
  const apps::ElevationArguments& elevation = arguments.planned.elevation;
  if (Status s = apps::checkOutput(arguments.output, "plan"); !s.ok()) return fail(s.error());
  for (const std::filesystem::path& file : apps::filesOf(elevation))
    if (Status s = apps::checkApart(arguments.output, file, "one of the inputs"); !s.ok()) return fail(s.error());
  const auto source = terrain::openElevation(elevation.inputs, elevation.open);
  if (!source.ok()) return fail(source.error());
  apps::describeInput((*source)->info());
  apps::ProgressLine line;
  const auto made = terrain::planBlocks(**source,
                                        {.height_quantum_m = apps::chooseVerticalStep(elevation, (*source)->info()),
                                         .widen_quantum = !elevation.vertical_step_m,
                                         .memory_bytes = uint64_t{arguments.memory_mib} << 20,
                                         .voids = apps::voidsBeside(arguments.output)},
                                        {.report = [&](std::string_view stage, double done) { line.show(stage, done); },
                                         .keepGoing = [] { return !apps::isStopRequested(); }});
  line.end();
  if (!made.ok()) return fail(made.error());
  if (Status s = apps::writePlan(arguments.output, words, arguments.planned, *made); !s.ok()) return fail(s.error());
  std::printf("%s: %zu blocks\n", arguments.output.c_str(), made->ids.size());
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{"Looks at elevation data and lists the blocks that make a scene of it, for many machines to make.",
               "foreland plan"};
  Arguments arguments;
  apps::describePlanned(app, arguments.planned);
  app.add_option("-o,--output", arguments.output, "the plan to write")->type_name(apps::file("PLAN.json"))->required();
  app.add_option("--memory", arguments.memory_mib, "MiB for heights")
      ->type_name(apps::whole("MIB"))
      ->check(apps::within(1u, 1u << 30))
      ->capture_default_str();
  apps::addConfiguration(app);
  const auto exit_code =
      apps::parseCommandLine(app, argc, argv,
                             {{"a scene by four jobs at a time",
                               "foreland plan tiles/*.tif -o plan.json && seq 0 $(($(grep -c '\"id\"' plan.json) - 2)) "
                               "| parallel -j4 foreland "
                               "block plan.json {} -o blocks && foreland merge plan.json blocks -o scene.fls"}});
  if (exit_code) return *exit_code;
  const std::vector<std::string> words = apps::plannedWords(app);
  apps::ElevationArguments& elevation = arguments.planned.elevation;
  apps::takeVerticals(elevation);
  if (Status s = apps::takeInsets(elevation); !s.ok()) return fail(s.error());
  elevation.open.allowed_folders = arguments.planned.foreign.allowed;
  apps::confineTo(arguments.planned.foreign, apps::filesOf(elevation), {arguments.output});
  apps::catchStopSignals();
  return plan(arguments, words);
}
