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

// So that hours are not spent on blocks before foreland merge says it.
Status checkAdditions(const apps::PlanArguments& planned, const terrain::ElevationInfo& ground,
                      const std::vector<terrain::EpochRequest>& epochs) {
  const auto opened = apps::openAdditions(planned.scene, ground, planned.foreign.allowed);
  if (!opened) return opened.error();
  return terrain::checkAdditions(ground, epochs, planned.epochs.blend, opened->additions);
}

// What foreland build takes and a plan does not is named with the way out, also where it stands in a file for both.
void describeRefused(CLI::App& app) {
  const auto refuse = [&](const std::string& name, const std::string& why) {
    app.add_option_function<std::vector<std::string>>(
           name, [name, why](const std::vector<std::string>&) { throw CLI::ValidationError(name, why); })
        ->group("");
  };
  const auto refuseFlag = [&](const std::string& name, const std::string& why) {
    app.add_flag_function(name, [name, why](int64_t) { throw CLI::ValidationError(name, why); })->group("");
  };
  const std::string globe = "a globe is not made by blocks yet; foreland build makes it";
  for (const char* name : {"--globe", "--sea"}) refuseFlag(name, globe);
  refuse("--threads", "a plan needs none; give it to foreland merge");
}

int plan(const Arguments& arguments, const std::vector<std::string>& words) {
  const apps::ElevationArguments& elevation = arguments.planned.elevation;
  if (Status s = apps::checkOutput(arguments.output, "plan"); !s.ok()) return fail(s.error());
  for (const std::filesystem::path& file : apps::filesOf(arguments.planned))
    if (Status s = apps::checkApart(arguments.output, file, "one of the inputs"); !s.ok()) return fail(s.error());
  const apps::EpochArguments& epochs = arguments.planned.epochs;
  const auto objects = apps::parseObjects(arguments.planned.scene);
  if (!objects.ok()) return fail(objects.error());
  auto of_poses = apps::epochsOfPoses(*objects);
  if (!of_poses.ok()) return fail(of_poses.error());
  auto ground = apps::openGround(elevation, epochs, std::move(*of_poses));
  if (!ground.ok()) return fail(ground.error());
  const terrain::ElevationInfo& info = ground->source->info();
  apps::describeInput(info);
  if (Status s = apps::openEpochs(elevation, epochs, *ground); !s.ok()) return fail(s.error());
  if (Status s = checkAdditions(arguments.planned, info, ground->epochs); !s.ok()) return fail(s.error());
  apps::ProgressLine line;
  const auto made = terrain::planBlocks(*ground->source,
                                        {.height_quantum_m = apps::chooseVerticalStep(elevation, info),
                                         .widen_quantum = !elevation.vertical_step_m,
                                         .memory_bytes = uint64_t{arguments.memory_mib} << 20,
                                         .epochs = ground->epochs,
                                         .epoch_blend = epochs.blend,
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
  describeRefused(app);
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
  apps::takeVerticals(arguments.planned.epochs, elevation.open);
  if (Status s = apps::takeInsets(elevation); !s.ok()) return fail(s.error());
  elevation.open.allowed_folders = arguments.planned.foreign.allowed;
  apps::confineTo(arguments.planned.foreign, apps::filesOf(arguments.planned), {arguments.output});
  apps::catchStopSignals();
  return plan(arguments, words);
}
