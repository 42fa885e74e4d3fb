// foreland-build: elevation files in, one scene file out. The only program besides foreland-synth that links GDAL and
// OpenEXR. Exit codes: 0 done, 2 anything else, with a line on stderr; nothing half-written stays.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <glm/vec2.hpp>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "apps/build/elevation_options.h"
#include "apps/build/epoch_options.h"
#include "apps/build/scene_options.h"
#include "apps/build/scene_report.h"
#include "apps/options/command_line.h"
#include "apps/options/foreign_files.h"
#include "apps/options/options.h"
#include "apps/options/output_file.h"
#include "apps/options/toml_config.h"
#include "apps/report/progress_line.h"
#include "apps/stop_signal.h"
#include "terrain/dem/open_globe.h"
#include "terrain/dem/pictures/globe_pictures.h"
#include "terrain/dem/vertical/height_reference.h"
#include "terrain/geo/geodesy.h"
#include "terrain/pipeline/build.h"
#include "terrain/pipeline/build_by_blocks.h"
#include "terrain/pipeline/globe_build.h"

namespace {

using namespace foreland;
using Clock = std::chrono::steady_clock;

struct Arguments {
  apps::ElevationArguments elevation;
  std::filesystem::path output;
  bool is_globe = false, has_sea = false;
  unsigned threads = 0, memory_mib = 1024;
  apps::SceneArguments scene;
  apps::EpochArguments epochs;
  apps::ForeignFiles foreign;
};

void describeElevation(CLI::App& app, Arguments& arguments) {
  app.add_option("-o,--output", arguments.output, "the scene file to write")
      ->type_name(apps::file("SCENE.fls"))
      ->required();
  CLI::Option* globe =
      app.add_flag("--globe", arguments.is_globe,
                   "the ground of a whole body: the inputs go around it, in latitude and longitude and to both poles, "
                   "and insets are fine where they are. Heights above a geoid (--vertical) become heights above the "
                   "ellipsoid");
  app.add_flag("--sea", arguments.has_sea,
               "viewers draw the sea over ground of the globe that lies below it: at height 0 above the geoid that "
               "--vertical names, or above the ellipsoid where nothing does; land below it is under water, too")
      ->needs(globe);
  apps::describeInputs(app, arguments.elevation);
  app.add_option("--threads", arguments.threads, "worker threads; 0 for one per processor")
      ->type_name(apps::whole("N"))
      ->check(apps::within(0u, 1024u))
      ->capture_default_str();
  app.add_option(
         "--memory", arguments.memory_mib,
         "MiB for heights: of inputs that take more (4 bytes a sample; 25 where the ground changes in time, and 4 for "
         "each "
         "sample of an epoch) a scene is made block by block, and blocks are kept beside it until it is complete, so "
         "that a build that ended goes on")
      ->type_name(apps::whole("MIB"))
      ->check(apps::within(1u, 1u << 30))
      ->capture_default_str();
}

int fail(const Error& error) {
  std::fprintf(stderr, "foreland build: %s\n", error.message.c_str());
  return 2;
}

// Called first, so that hours are not spent on a file that cannot be written.
Status checkOutput(const Arguments& arguments) {
  if (Status s = apps::checkOutput(arguments.output, "scene file"); !s.ok()) return s;
  for (const std::filesystem::path& input : arguments.elevation.inputs)
    if (Status s = apps::checkApart(arguments.output, input, "one of the inputs"); !s.ok()) return s;
  for (const terrain::InsetFile& inset : arguments.elevation.open.insets)
    if (Status s = apps::checkApart(arguments.output, inset.file, "one of the insets"); !s.ok()) return s;
  for (const std::filesystem::path& epoch : apps::filesOf(arguments.epochs))
    if (Status s = apps::checkApart(arguments.output, epoch, "one of the epochs"); !s.ok()) return s;
  return apps::checkApart(arguments.output, arguments.scene);
}

// All files that the command names, for reading. Some may not be there.
std::vector<std::filesystem::path> filesOf(const Arguments& arguments) {
  std::vector<std::filesystem::path> files = apps::filesOf(arguments.elevation);
  const std::vector<std::filesystem::path> of_scene = apps::filesOf(arguments.scene);
  files.insert(files.end(), of_scene.begin(), of_scene.end());
  const std::vector<std::filesystem::path> of_epochs = apps::filesOf(arguments.epochs);
  files.insert(files.end(), of_epochs.begin(), of_epochs.end());
  return files;
}

// What a globe cannot have.
Status checkGlobe(const Arguments& arguments) {
  const auto refused = [](const char* what) {
    return Error{ErrorCode::kUnsupported, std::string("--globe takes no ") + what + " yet; leave it out"};
  };
  if (!arguments.epochs.epochs.empty()) return refused("--epoch");
  if (arguments.elevation.open.scene_vertical && *arguments.elevation.open.scene_vertical != terrain::kEllipsoidName)
    return Error{ErrorCode::kInvalidArgument, "--scene-vertical " + *arguments.elevation.open.scene_vertical +
                                                  ": the heights of a globe are above the ellipsoid; leave it out"};
  return {};
}

void describeGlobe(const terrain::GlobeInfo& info, const terrain::GlobeDepth& depth) {
  std::fprintf(stderr, "%s: a globe of 6 x 2^%u x 2^%u cells", info.title.c_str(), depth.whole_log2, depth.whole_log2);
  if (depth.deepest_log2 > depth.whole_log2)
    std::fprintf(stderr, ", and as fine as 6 x 2^%u x 2^%u where insets are", depth.deepest_log2, depth.deepest_log2);
  std::fprintf(stderr, "\n");
}

// Builds with a line of progress, and describes the scene. The exit code.
template <class Build>
int runBuild(const Arguments& arguments, Clock::time_point begun, const Build& build) {
  apps::ProgressLine line;
  const Result<terrain::BuildReport> built =
      build(terrain::Progress{.report = [&](std::string_view stage, double done) { line.show(stage, done); },
                              .keepGoing = [] { return !apps::isStopRequested(); }});
  line.end();
  if (!built.ok()) return fail(built.error());
  apps::printScene(*built, arguments.output, std::chrono::duration<double>(Clock::now() - begun).count());
  return 0;
}

int buildGlobe(const Arguments& arguments) {
  const Clock::time_point begun = Clock::now();
  if (Status s = checkOutput(arguments); !s.ok()) return fail(s.error());
  if (Status s = checkGlobe(arguments); !s.ok()) return fail(s.error());
  terrain::OpenOptions open = arguments.elevation.open;
  open.scene_vertical.reset();
  const auto source = terrain::openGlobe(arguments.elevation.inputs, open);
  if (!source.ok()) return fail(source.error());
  const auto depth = terrain::depthOf((*source)->info(), open.residual_m);
  if (!depth.ok()) return fail(depth.error());
  describeGlobe((*source)->info(), *depth);
  const auto objects = apps::parseObjects(arguments.scene);
  if (!objects.ok()) return fail(objects.error());
  std::unique_ptr<terrain::GlobePicture> picture;
  const apps::SceneArguments& scene = arguments.scene;
  if (!scene.imagery.empty()) {
    auto opened = terrain::openGlobePictures(scene.imagery, arguments.foreign.allowed, scene.imagery_alpha);
    if (!opened.ok()) return fail(opened.error());
    picture = std::move(opened).value();
  }
  return runBuild(arguments, begun, [&](const terrain::Progress& progress) {
    return terrain::buildGlobe(**source,
                               {.output = arguments.output,
                                .height_quantum_m = arguments.elevation.vertical_step_m.value_or(0.1),
                                .threads = arguments.threads,
                                .residual_m = open.residual_m,
                                .page_coding = arguments.scene.page_coding,
                                .objects = *objects,
                                .picture = picture.get(),
                                .imagery_quality = scene.imagery_quality,
                                .attribution = scene.attribution,
                                .has_sea = arguments.has_sea},
                               progress);
  });
}

// About what a build at once holds of heights: in time also the lowest and the highest, the ground of a date, errors,
// and all that epochs say.
uint64_t bytesAtOnce(const terrain::ElevationInfo& info, const std::vector<terrain::EpochRequest>& epochs) {
  const auto samples = [](const terrain::ElevationInfo& of) { return uint64_t{of.width} * of.height; };
  uint64_t bytes = samples(info) * (epochs.empty() ? sizeof(float) : 25);
  for (const terrain::EpochRequest& epoch : epochs)
    if (epoch.source) bytes += samples(epoch.source->info()) * sizeof(float);
  return bytes;
}

// Whether heights take more memory than they may, and all that is wanted can be made block by block.
bool isByBlocks(const Arguments& arguments, const terrain::ElevationSource& source,
                const terrain::BuildOptions& options) {
  return bytesAtOnce(source.info(), options.epochs) > uint64_t{arguments.memory_mib} << 20 &&
         terrain::emptyPlan(source, options.height_quantum_m, 10, options.epoch_blend).ok();
}

Result<terrain::BuildReport> buildByBlocks(const Arguments& arguments, terrain::ElevationSource& source,
                                           const terrain::BuildOptions& options, const terrain::Progress& progress) {
  return terrain::buildByBlocks(source,
                                {.plan = {.height_quantum_m = options.height_quantum_m,
                                          .widen_quantum = options.widen_quantum,
                                          .memory_bytes = uint64_t{arguments.memory_mib} << 20,
                                          .epochs = options.epochs,
                                          .epoch_blend = options.epoch_blend},
                                 .output = options.output,
                                 .threads = options.threads,
                                 .additions = options.additions},
                                progress);
}

int build(const Arguments& arguments) {
  const Clock::time_point begun = Clock::now();
  if (Status s = checkOutput(arguments); !s.ok()) return fail(s.error());
  const auto objects = apps::parseObjects(arguments.scene);
  if (!objects.ok()) return fail(objects.error());
  auto of_poses = apps::epochsOfPoses(*objects);
  if (!of_poses.ok()) return fail(of_poses.error());
  auto ground = apps::openGround(arguments.elevation, arguments.epochs, std::move(*of_poses));
  if (!ground.ok()) return fail(ground.error());
  const std::unique_ptr<terrain::ElevationSource>& source = ground->source;
  apps::describeInput(source->info());
  if (Status s = apps::openEpochs(arguments.elevation, arguments.epochs, *ground); !s.ok()) return fail(s.error());
  const auto with = apps::openAdditions(arguments.scene, source->info(), arguments.foreign.allowed);
  if (!with.ok()) return fail(with.error());
  const terrain::BuildOptions options{.output = arguments.output,
                                      .height_quantum_m = apps::chooseVerticalStep(arguments.elevation, source->info()),
                                      .threads = arguments.threads,
                                      .widen_quantum = !arguments.elevation.vertical_step_m,
                                      .epochs = ground->epochs,
                                      .epoch_blend = arguments.epochs.blend,
                                      .additions = with->additions};
  return runBuild(arguments, begun, [&](const terrain::Progress& progress) {
    return isByBlocks(arguments, *source, options) ? buildByBlocks(arguments, *source, options, progress)
                                                   : terrain::buildScene(*source, options, progress);
  });
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{"Makes a scene file from elevation data.", "foreland build"};
  Arguments arguments;
  describeElevation(app, arguments);
  apps::describeAdditions(app, arguments.scene);
  apps::describeEpochs(app, arguments.epochs);
  apps::addForeignFiles(app, arguments.foreign);
  apps::addConfiguration(app);
  const auto exit_code = apps::parseCommandLine(
      app, argc, argv,
      {{"one file", "foreland build hills.tif -o hills.fls"},
       {"a survey in the coarse ground around it",
        "foreland build alps.tif --inset survey.tif --feather 50 -o alps.fls"},
       {"a whole planet, finer where a survey is",
        "foreland build etopo20.cdf --globe --vertical egm96 --sea --inset alps.tif -o planet.fls"},
       {"a tower on a summit, twice as large as modelled and facing east",
        "foreland build N46E008.hgt -o alps.fls --object tower.fls@46.5900,8.1183,0,90,2"},
       {"ground that changes in time",
        "foreland build msh.tif --epoch 2000-09-25=01.tif --epoch 2004-10-04=02.tif -o dome.fls"},
       {"all of a world in a file: INPUT = ['etopo20.cdf'], globe = true, inset = ['alps.tif', 'fuji.tif']",
        "foreland build --config WORLD.toml -o planet.fls"}});
  if (exit_code) return *exit_code;
  apps::takeVerticals(arguments.elevation);
  apps::takeVerticals(arguments.epochs, arguments.elevation.open);
  if (Status s = apps::takeInsets(arguments.elevation); !s.ok()) return fail(s.error());
  arguments.elevation.open.allowed_folders = arguments.foreign.allowed;
  apps::confineTo(arguments.foreign, filesOf(arguments), {arguments.output});
  apps::catchStopSignals();
  return arguments.is_globe ? buildGlobe(arguments) : build(arguments);
}
