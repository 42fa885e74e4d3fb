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
#include "terrain/dem/pictures/open_pictures.h"
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
  terrain::PageCoding page_coding = terrain::PageCoding::kPlain;
  std::vector<std::string> objects, epochs;
  proto::EpochBlend epoch_blend = proto::EpochBlend::kLinear;
  std::vector<std::filesystem::path> imagery;
  int imagery_quality = terrain::kDefaultImageryQuality;
  terrain::AlphaChoice imagery_alpha = terrain::AlphaChoice::kAuto;
  std::string attribution;
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
         "MiB for heights: of inputs that take more (4 bytes a sample), a scene of ground alone in plain pages is "
         "made block by block, and blocks are kept beside it until it is complete, so that a build that ended goes on")
      ->type_name(apps::whole("MIB"))
      ->check(apps::within(1u, 1u << 30))
      ->capture_default_str();
  static const std::map<std::string, terrain::PageCoding> codings{{"plain", terrain::PageCoding::kPlain},
                                                                  {"coded", terrain::PageCoding::kCoded}};
  app.add_option_function<std::string>(
         "--pages", [&](const std::string& name) { arguments.page_coding = codings.at(name); },
         "how the ground stands in the file: plain, eight bytes a sample, which are used where they lie; coded: about "
         "a tenth, inflated when they are first touched (serve --page-cache-mib), for scenes larger than memory "
         "and disk. What viewers get is the same")
      ->check(apps::oneOf({"plain", "coded"}))
      ->default_str("plain");
}

void describeChanges(CLI::App& app, Arguments& arguments) {
  app.add_option(
         "--object", arguments.objects,
         "a surface made by `foreland remesh` that stands on the terrain; LAT and LON in degrees, in planar "
         "scenes x and y of the map in metres; here: where the model's own coordinates are on the "
         "map of the scene, and at their height. The dates of its poses are the scene's epochs, unless there is "
         "--epoch: then each is one of these")
      ->type_name(apps::text("MODEL.fls@LAT,LON|here[,HEIGHT[,HEADING[,SCALE]]]"))
      ->allow_extra_args(false);
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

void describeImagery(CLI::App& app, Arguments& arguments) {
  CLI::Option* imagery = app.add_option(
      "--imagery", arguments.imagery,
      "pictures to lay over the terrain: whatever GDAL reads, grey, palette, RGB or RGBA of 8 bits, in any reference "
      "system; where they overlap, the finest shows. One without georeference is laid over the whole scene");
  imagery->type_name(apps::file("FILE"));
  app.add_option("--imagery-quality", arguments.imagery_quality, "of the pictures' WebP")
      ->type_name(apps::whole("Q"))
      ->check(apps::within(1, 100))
      ->needs(imagery)
      ->capture_default_str();
  static const std::map<std::string, terrain::AlphaChoice> alphas{{"auto", terrain::AlphaChoice::kAuto},
                                                                  {"use", terrain::AlphaChoice::kUse},
                                                                  {"ignore", terrain::AlphaChoice::kIgnore}};
  app.add_option_function<std::string>(
         "--imagery-alpha", [&](const std::string& name) { arguments.imagery_alpha = alphas.at(name); },
         "what to make of a last band of the pictures that is tagged as alpha; by default it is left out, with a note, "
         "where it is hardly anywhere opaque, as infrared is not")
      ->check(apps::oneOf({"auto", "use", "ignore"}))
      ->needs(imagery)
      ->default_str("auto");
  app.add_option("--attribution", arguments.attribution, "whom viewers name where they show the pictures")
      ->type_name(apps::text("NAME"))
      ->needs(imagery);
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
  for (const std::filesystem::path& picture : arguments.imagery)
    if (Status s = apps::checkApart(arguments.output, picture, "one of the pictures"); !s.ok()) return s;
  return {};
}

void describeScene(const terrain::BuildReport& report, const std::filesystem::path& output, double seconds) {
  for (const std::string& note : report.notes) std::fprintf(stderr, "note: %s\n", note.c_str());
  for (const std::string& warning : report.warnings) std::fprintf(stderr, "warning: %s\n", warning.c_str());
  for (const terrain::EpochReport& epoch : report.epochs)
    std::printf("  epoch %s: %llu samples changed, by %.1f m at most, %.3f MB\n", epoch.date.c_str(),
                static_cast<unsigned long long>(epoch.changed_samples), epoch.max_m,
                static_cast<double>(epoch.bytes) * 1e-6);
  if (report.imagery.tiles > 0)
    std::printf("  imagery: %llu tiles, and %llu whose parents show the same\n",
                static_cast<unsigned long long>(report.imagery.stored),
                static_cast<unsigned long long>(report.imagery.tiles - report.imagery.stored));
  std::printf("%s: %u x %u samples, %llu nodes, heights %.1f to %.1f m, %llu voids filled, %.1f MB, %.1f s\n",
              output.c_str(), report.width, report.height, static_cast<unsigned long long>(report.nodes),
              report.lowest_m, report.highest_m, static_cast<unsigned long long>(report.voids_filled),
              static_cast<double>(report.file_bytes) * 1e-6, seconds);
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
  files.insert(files.end(), arguments.imagery.begin(), arguments.imagery.end());
  for (const std::string& text : arguments.epochs) files.emplace_back(text.substr(text.find('=') + 1));
  for (const std::string& text : arguments.objects) files.emplace_back(text.substr(0, text.rfind('@')));
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

Result<std::vector<terrain::ObjectRequest>> parseObjects(const std::vector<std::string>& texts) {
  std::vector<terrain::ObjectRequest> objects;
  for (const std::string& text : texts) {
    auto object = terrain::parseObject(text);
    if (!object.ok()) return object.error();
    objects.push_back(std::move(*object));
  }
  return objects;
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
  describeScene(*built, arguments.output, std::chrono::duration<double>(Clock::now() - begun).count());
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
  const auto objects = parseObjects(arguments.objects);
  if (!objects.ok()) return fail(objects.error());
  std::unique_ptr<terrain::GlobePicture> picture;
  if (!arguments.imagery.empty()) {
    auto opened = terrain::openGlobePictures(arguments.imagery, arguments.foreign.allowed, arguments.imagery_alpha);
    if (!opened.ok()) return fail(opened.error());
    picture = std::move(opened).value();
  }
  return runBuild(arguments, begun, [&](const terrain::Progress& progress) {
    return terrain::buildGlobe(**source,
                               {.output = arguments.output,
                                .height_quantum_m = arguments.elevation.vertical_step_m.value_or(0.1),
                                .threads = arguments.threads,
                                .residual_m = open.residual_m,
                                .page_coding = arguments.page_coding,
                                .objects = *objects,
                                .picture = picture.get(),
                                .imagery_quality = arguments.imagery_quality,
                                .attribution = arguments.attribution,
                                .has_sea = arguments.has_sea},
                               progress);
  });
}

// Whether heights take more memory than they may, and all that is wanted can be made block by block.
bool isByBlocks(const Arguments& arguments, const terrain::ElevationSource& source,
                const terrain::BuildOptions& options) {
  const terrain::ElevationInfo& info = source.info();
  const uint64_t bytes = uint64_t{info.width} * info.height * sizeof(float);
  return bytes > uint64_t{arguments.memory_mib} << 20 && options.objects.empty() && options.epochs.empty() &&
         options.picture == nullptr && options.page_coding == terrain::PageCoding::kPlain &&
         terrain::emptyPlan(source, options.height_quantum_m, 10).ok();
}

Result<terrain::BuildReport> buildByBlocks(const Arguments& arguments, terrain::ElevationSource& source,
                                           const terrain::BuildOptions& options, const terrain::Progress& progress) {
  return terrain::buildByBlocks(source,
                                {.plan = {.height_quantum_m = options.height_quantum_m,
                                          .widen_quantum = options.widen_quantum,
                                          .memory_bytes = uint64_t{arguments.memory_mib} << 20},
                                 .output = options.output,
                                 .threads = options.threads},
                                progress);
}

int build(const Arguments& arguments) {
  const Clock::time_point begun = Clock::now();
  if (Status s = checkOutput(arguments); !s.ok()) return fail(s.error());
  auto objects = parseObjects(arguments.objects);
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
                                .page_coding = arguments.page_coding,
                                .widen_quantum = !arguments.elevation.vertical_step_m,
                                .objects = std::move(*objects)};
  auto epochs = openEpochs(arguments, verticalOfScene(arguments, (*source)->info()), (*source)->info());
  if (!epochs.ok()) return fail(epochs.error());
  options.epochs = epochs->requests.empty() ? std::move(*of_poses) : epochs->requests;
  options.epoch_blend = arguments.epoch_blend;
  std::unique_ptr<terrain::PictureSource> picture;
  if (!arguments.imagery.empty()) {
    const terrain::ElevationInfo& info = (*source)->info();
    auto opened = terrain::openPictures(arguments.imagery, {info.frame, info.crs_wkt, info.width, info.height,
                                                            arguments.foreign.allowed, arguments.imagery_alpha});
    if (!opened.ok()) return fail(opened.error());
    picture = std::move(opened).value();
    options.picture = picture.get();
    options.imagery_quality = arguments.imagery_quality;
    options.attribution = arguments.attribution;
  }
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
  describeImagery(app, arguments);
  describeChanges(app, arguments);
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
