// foreland-build: elevation files in, one scene file out. The only program besides foreland-synth that links GDAL and
// OpenEXR. Exit codes: 0 done, 2 anything else, with a line on stderr; nothing half-written stays.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <glm/vec2.hpp>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "apps/build/elevation_options.h"
#include "apps/build/scene_options.h"
#include "apps/build/scene_report.h"
#include "apps/options/command_line.h"
#include "apps/options/date.h"
#include "apps/options/foreign_files.h"
#include "apps/options/options.h"
#include "apps/options/output_file.h"
#include "apps/options/toml_config.h"
#include "apps/report/progress_line.h"
#include "apps/stop_signal.h"
#include "terrain/dem/on_lattice.h"
#include "terrain/dem/open.h"
#include "terrain/dem/open_globe.h"
#include "terrain/dem/pictures/globe_pictures.h"
#include "terrain/dem/vertical/height_reference.h"
#include "terrain/geo/geodesy.h"
#include "terrain/pipeline/build.h"
#include "terrain/pipeline/build_by_blocks.h"
#include "terrain/pipeline/globe_build.h"
#include "terrain/surface_store/mapped_surface.h"

namespace {

using namespace foreland;
using Clock = std::chrono::steady_clock;

struct Arguments {
  apps::ElevationArguments elevation;
  std::filesystem::path output;
  bool is_globe = false, has_sea = false;
  unsigned threads = 0, memory_mib = 1024;
  apps::SceneArguments scene;
  std::vector<std::string> epochs;
  proto::EpochBlend epoch_blend = proto::EpochBlend::kLinear;
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
         "MiB for heights: of inputs that take more (4 bytes a sample), a scene that does not change in time is made "
         "block by block, and blocks are kept beside it until it is complete, so that a build that ended goes on")
      ->type_name(apps::whole("MIB"))
      ->check(apps::within(1u, 1u << 30))
      ->capture_default_str();
}

void describeEpochs(CLI::App& app, Arguments& arguments) {
  app.add_option("--epoch", arguments.epochs,
                 "the ground at a date: the scene changes in time from the first date to the last. The file may have "
                 "any grid and resolution; outside of it, and where it has no data, the ground is as at the date "
                 "before. The first is laid over INPUT")
      ->type_name(apps::text("YYYY-MM-DD=FILE"))
      ->allow_extra_args(false);
  static const std::map<std::string, proto::EpochBlend> blends{{"linear", proto::EpochBlend::kLinear},
                                                               {"catmull-rom", proto::EpochBlend::kCatmullRom},
                                                               {"b-spline", proto::EpochBlend::kBSpline}};
  app.add_option_function<std::string>(
         "--epoch-blend", [&](const std::string& name) { arguments.epoch_blend = blends.at(name); },
         "how the ground moves from date to date: straight; catmull-rom: smoothly through every date's; b-spline: more "
         "smoothly, and past all but the first and the last")
      ->check(apps::oneOf({"linear", "catmull-rom", "b-spline"}))
      ->default_str("linear");
}

// From here on inputs and epochs are names of files.
void takeVerticals(Arguments& arguments) {
  apps::takeVerticals(arguments.elevation);
  for (std::string& epoch : arguments.epochs) {
    const size_t split = epoch.find('=');
    if (split != std::string::npos && epoch.find(apps::kVerticalOfOne) > split)
      epoch = epoch.substr(0, split + 1) + apps::withoutVertical(epoch.substr(split + 1), arguments.elevation.open);
  }
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
  return apps::checkApart(arguments.output, arguments.scene);
}

struct OpenedEpochs {
  std::vector<std::unique_ptr<terrain::ElevationSource>> sources;
  std::vector<terrain::EpochRequest> requests;
};

// Epochs at which the ground stays as it is, for the poses of the objects.
Result<std::vector<terrain::EpochRequest>> epochsOfPoses(const std::vector<terrain::ObjectRequest>& objects) {
  std::set<Time> times;
  for (const terrain::ObjectRequest& object : objects) {
    const auto surface = terrain::MappedSurface::open(object.model);
    if (!surface.ok()) return surface.error();
    times.insert((*surface)->poseTimes().begin(), (*surface)->poseTimes().end());
  }
  std::vector<terrain::EpochRequest> epochs;
  for (const Time& time : times) epochs.push_back({time, apps::dateText(time), nullptr});
  return epochs;
}

// Heights of epochs count from what the scene's do, and lie on its lattice.
Result<OpenedEpochs> openEpochs(const Arguments& arguments, const std::string& scene_vertical,
                                const terrain::ElevationInfo& scene) {
  OpenedEpochs epochs;
  terrain::OpenOptions open = arguments.elevation.open;
  open.insets.clear();
  if (!scene_vertical.empty()) open.scene_vertical = scene_vertical;
  for (const std::string& text : arguments.epochs) {
    const size_t split = text.find('=');
    const auto time = split == std::string::npos ? std::nullopt : apps::parseDate(text.substr(0, split));
    if (!time || split + 1 == text.size())
      return Error{ErrorCode::kInvalidArgument, "--epoch " + text +
                                                    ": write YYYY-MM-DD=FILE, for example "
                                                    "2004-10-04=dome.tif"};
    const std::filesystem::path file = text.substr(split + 1);
    if (Status s = apps::checkApart(arguments.output, file, "one of the epochs"); !s.ok()) return s.error();
    auto source = terrain::openElevation({file}, open);
    if (source.ok() && !terrain::isOnLatticeOf((*source)->info(), scene))
      source = terrain::openOnLattice(file, open, scene);
    if (!source) return Error{source.error().code, "epoch " + text.substr(0, split) + ": " + source.error().message};
    epochs.requests.push_back({*time, text.substr(0, split), source->get()});
    epochs.sources.push_back(std::move(*source));
  }
  return epochs;
}

// All files that the command names, for reading. Some may not be there.
std::vector<std::filesystem::path> filesOf(const Arguments& arguments) {
  std::vector<std::filesystem::path> files = apps::filesOf(arguments.elevation);
  const std::vector<std::filesystem::path> of_scene = apps::filesOf(arguments.scene);
  files.insert(files.end(), of_scene.begin(), of_scene.end());
  for (const std::string& text : arguments.epochs) files.emplace_back(text.substr(text.find('=') + 1));
  return files;
}

// As an option would say it; empty if nothing is stated, or no option can say it.
std::string verticalOfScene(const Arguments& arguments, const terrain::ElevationInfo& info) {
  if (info.vertical.name.empty()) return {};
  if (arguments.elevation.open.scene_vertical) return *arguments.elevation.open.scene_vertical;
  const auto own = arguments.elevation.open.vertical_of.find(arguments.elevation.inputs.front().string());
  const auto choice = own != arguments.elevation.open.vertical_of.end() ? std::optional(own->second)
                                                                        : arguments.elevation.open.vertical;
  return choice && *choice != terrain::kAsTheFileSays ? *choice : terrain::choiceNamed(info.vertical.name);
}

// What a globe cannot have.
Status checkGlobe(const Arguments& arguments) {
  const auto refused = [](const char* what) {
    return Error{ErrorCode::kUnsupported, std::string("--globe takes no ") + what + " yet; leave it out"};
  };
  if (!arguments.epochs.empty()) return refused("--epoch");
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

// Whether heights take more memory than they may, and all that is wanted can be made block by block.
bool isByBlocks(const Arguments& arguments, const terrain::ElevationSource& source,
                const terrain::BuildOptions& options) {
  const terrain::ElevationInfo& info = source.info();
  const uint64_t bytes = uint64_t{info.width} * info.height * sizeof(float);
  return bytes > uint64_t{arguments.memory_mib} << 20 && options.epochs.empty() &&
         options.epoch_blend == proto::EpochBlend::kLinear &&
         terrain::emptyPlan(source, options.height_quantum_m, 10).ok();
}

Result<terrain::BuildReport> buildByBlocks(const Arguments& arguments, terrain::ElevationSource& source,
                                           const terrain::BuildOptions& options, const terrain::Progress& progress) {
  return terrain::buildByBlocks(source,
                                {.plan = {.height_quantum_m = options.height_quantum_m,
                                          .widen_quantum = options.widen_quantum,
                                          .memory_bytes = uint64_t{arguments.memory_mib} << 20},
                                 .output = options.output,
                                 .threads = options.threads,
                                 .additions = {.page_coding = options.page_coding,
                                               .objects = options.objects,
                                               .picture = options.picture,
                                               .imagery_quality = options.imagery_quality,
                                               .attribution = options.attribution}},
                                progress);
}

int build(const Arguments& arguments) {
  const Clock::time_point begun = Clock::now();
  if (Status s = checkOutput(arguments); !s.ok()) return fail(s.error());
  auto objects = apps::parseObjects(arguments.scene);
  if (!objects.ok()) return fail(objects.error());
  auto of_poses = epochsOfPoses(*objects);
  if (!of_poses.ok()) return fail(of_poses.error());
  terrain::OpenOptions open = arguments.elevation.open;
  // What changes in time has heights everywhere.
  if (!arguments.epochs.empty() || !of_poses->empty()) open.lattice = terrain::LatticeChoice::kWhole;
  auto source = terrain::openElevation(arguments.elevation.inputs, open);
  if (!source.ok()) return fail(source.error());
  apps::describeInput((*source)->info());
  terrain::BuildOptions options{.output = arguments.output,
                                .height_quantum_m = apps::chooseVerticalStep(arguments.elevation, (*source)->info()),
                                .threads = arguments.threads,
                                .page_coding = arguments.scene.page_coding,
                                .widen_quantum = !arguments.elevation.vertical_step_m,
                                .objects = std::move(*objects)};
  auto epochs = openEpochs(arguments, verticalOfScene(arguments, (*source)->info()), (*source)->info());
  if (!epochs.ok()) return fail(epochs.error());
  options.epochs = epochs->requests.empty() ? std::move(*of_poses) : epochs->requests;
  options.epoch_blend = arguments.epoch_blend;
  const auto picture = apps::openPictures(arguments.scene, (*source)->info(), arguments.foreign.allowed);
  if (!picture.ok()) return fail(picture.error());
  options.picture = picture->get();
  options.imagery_quality = arguments.scene.imagery_quality;
  options.attribution = arguments.scene.attribution;
  return runBuild(arguments, begun, [&](const terrain::Progress& progress) {
    return isByBlocks(arguments, **source, options) ? buildByBlocks(arguments, **source, options, progress)
                                                    : terrain::buildScene(**source, options, progress);
  });
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{"Makes a scene file from elevation data.", "foreland build"};
  Arguments arguments;
  describeElevation(app, arguments);
  apps::describeAdditions(app, arguments.scene);
  describeEpochs(app, arguments);
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
  takeVerticals(arguments);
  if (Status s = apps::takeInsets(arguments.elevation); !s.ok()) return fail(s.error());
  arguments.elevation.open.allowed_folders = arguments.foreign.allowed;
  apps::confineTo(arguments.foreign, filesOf(arguments), {arguments.output});
  apps::catchStopSignals();
  return arguments.is_globe ? buildGlobe(arguments) : build(arguments);
}
