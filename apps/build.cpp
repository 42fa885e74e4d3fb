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

#include "apps/options/command_line.h"
#include "apps/options/date.h"
#include "apps/options/foreign_files.h"
#include "apps/options/options.h"
#include "apps/options/output_file.h"
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
#include "terrain/pipeline/globe_build.h"
#include "terrain/surface_store/mapped_surface.h"

namespace {

using namespace foreland;
using Clock = std::chrono::steady_clock;

struct Arguments {
  std::vector<std::filesystem::path> inputs;
  std::filesystem::path output;
  std::vector<std::string> insets;
  std::vector<int> inset_priorities;
  terrain::OpenOptions open;
  bool is_globe = false;
  std::optional<double> vertical_step_m;
  unsigned threads = 0;
  terrain::PageCoding page_coding = terrain::PageCoding::kPlain;
  std::vector<std::string> objects, epochs;
  proto::EpochBlend epoch_blend = proto::EpochBlend::kLinear;
  std::vector<std::filesystem::path> imagery;
  int imagery_quality = terrain::kDefaultImageryQuality;
  terrain::AlphaChoice imagery_alpha = terrain::AlphaChoice::kAuto;
  std::string attribution;
  apps::ForeignFiles foreign;
};

void describeInsets(CLI::App& app, Arguments& arguments) {
  CLI::Option* inset = app.add_option(
      "--inset", arguments.insets,
      "elevation of another grid, resolution or reference system that is laid over the inputs: the lattice becomes as "
      "fine as the finest inset, of several the one named first lies on top, and its voids show what is below. An "
      "inset that is coarser than the inputs shows only where these have voids");
  inset->type_name(apps::file("FILE"))->allow_extra_args(false);
  app.add_option("--inset-priority", arguments.inset_priorities,
                 "of the insets in their order, as many as there are: those of a higher one lie over others")
      ->type_name(apps::whole("N"))
      ->allow_extra_args(false)
      ->needs(inset);
  app.add_option("--feather", arguments.open.feather_m,
                 "metres over which an inset's edges are mixed with what is below it; by default four samples of the "
                 "inputs, and at most an eighth of the inset's shorter side")
      ->type_name(apps::number("M"))
      ->check(apps::within(0.0, 1e7));
  app.add_option(
         "--residual", arguments.open.residual_m,
         "metres that the scene may be off an inset's samples before heights are rounded: the lattice is refined "
         "only as far as that takes, and to at most a quarter of the finest inset's distance between samples")
      ->type_name(apps::number("M"))
      ->check(apps::above(0));
}

void describeElevation(CLI::App& app, Arguments& arguments) {
  app.add_option(
         "INPUT", arguments.inputs,
         "elevation files: whatever GDAL reads (GeoTIFF, HGT, zipped too, ASCII grid, netCDF, USGS DEM, PNG), or "
         "OpenEXR height maps; several make a mosaic")
      ->type_name(apps::file("INPUT"))
      ->required();
  app.add_option("-o,--output", arguments.output, "the scene file to write")
      ->type_name(apps::file("SCENE.fls"))
      ->required();
  app.add_flag("--globe", arguments.is_globe,
               "the ground of a whole body: the inputs go around it, in latitude and longitude and to both poles, and "
               "insets are fine where they are. Heights above a geoid (--vertical) become heights above the ellipsoid");
  app.add_option("--nodata", arguments.open.nodata, "treat this height as a void, whatever the file says")
      ->type_name(apps::number("V"));
  app.add_option("--vertical-step", arguments.vertical_step_m,
                 "heights are rounded to multiples of this many metres; by default 1, 0.5 or 0.25 if all heights are "
                 "multiples of it, else 0.1, and finer for samples closer than 2 m")
      ->type_name(apps::number("M"))
      ->check(apps::above(0));
  app.add_option("--spacing", arguments.open.spacing_m,
                 "metres between samples, for files without a reference system (OpenEXR, PNG)")
      ->type_name(apps::number("M"))
      ->check(apps::isFinite());
  app.add_option("--channel", arguments.open.channel, "EXR channel, band number, or variable of a file with several")
      ->type_name(apps::text("NAME"));
  static const std::map<std::string, terrain::FrameChoice> frames{{"auto", terrain::FrameChoice::kAuto},
                                                                  {"planar", terrain::FrameChoice::kPlanar},
                                                                  {"projected", terrain::FrameChoice::kPlanar},
                                                                  {"geographic", terrain::FrameChoice::kGeographic}};
  app.add_option_function<std::string>(
         "--frame", [&](const std::string& name) { arguments.open.frame = frames.at(name); },
         "how to interpret the coordinates; by default as the file's reference system says, but in latitude and "
         "longitude "
         "where its map is off by more than 0.5 %, as Mercator's; projected keeps the map; planar flattens degrees, "
         "too")
      ->check(apps::oneOf({"auto", "planar", "projected", "geographic"}))
      ->default_str("auto");
  static const std::map<std::string, double> units{{"m", 1},     {"ft", 0.3048}, {"us-ft", 1200.0 / 3937.0},
                                                   {"km", 1000}, {"cm", 0.01},   {"mm", 0.001}};
  app.add_option_function<std::string>(
         "--height-unit", [&](const std::string& name) { arguments.open.height_unit = units.at(name); },
         "of the heights in the files, whatever they say; by default as their bands say, else the vertical parts of "
         "their "
         "reference systems, else metres")
      ->check(apps::oneOf({"m", "ft", "us-ft", "km", "cm", "mm"}));
  static const std::map<std::string, terrain::HeightEncoding> encodings{
      {"plain", terrain::HeightEncoding::kPlain},
      {"terrarium", terrain::HeightEncoding::kTerrarium},
      {"terrain-rgb", terrain::HeightEncoding::kTerrainRgb}};
  app.add_option_function<std::string>(
         "--encoding", [&](const std::string& name) { arguments.open.encoding = encodings.at(name); },
         "how samples encode heights; terrarium: red * 256 + green + blue / 256 - 32768; terrain-rgb: (red * 65536 + "
         "green * 256 + blue) / 10 - 10000; of pictures whose colours are heights it is found out")
      ->check(apps::oneOf({"plain", "terrarium", "terrain-rgb"}))
      ->default_str("plain");
  app.add_option("--vertical", arguments.open.vertical,
                 "what the heights of the inputs are above: ellipsoid, egm96, egm2008, a grid of undulations that PROJ "
                 "reads (.gtx, .tif), or file: what each file's reference system says; INPUT@vertical=... is for one "
                 "input. Inputs above different surfaces are brought to one before they are merged. By default as the "
                 "reference systems say")
      ->type_name(apps::text("DATUM"));
  app.add_option("--scene-vertical", arguments.open.scene_vertical,
                 "what the heights of the scene are to be above, as for --vertical; by default as the first input's")
      ->type_name(apps::text("DATUM"));
  describeInsets(app, arguments);
  static const std::map<std::string, terrain::PageCoding> codings{{"plain", terrain::PageCoding::kPlain},
                                                                  {"coded", terrain::PageCoding::kCoded}};
  app.add_option_function<std::string>(
         "--pages", [&](const std::string& name) { arguments.page_coding = codings.at(name); },
         "how the ground stands in the file: plain, eight bytes a sample, which are used where they lie; coded: about "
         "a tenth, inflated when they are first touched (serve --page-cache-mib), for scenes larger than memory "
         "and disk. What viewers get is the same")
      ->check(apps::oneOf({"plain", "coded"}))
      ->default_str("plain");
  app.add_option("--threads", arguments.threads, "worker threads; 0 for one per processor")
      ->type_name(apps::whole("N"))
      ->check(apps::within(0u, 1024u))
      ->capture_default_str();
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

constexpr std::string_view kVerticalOfOne = "@vertical=";

// Takes what follows a file's name off it, and remembers it for that file.
std::string withoutVertical(const std::string& text, terrain::OpenOptions& open) {
  const size_t at = text.rfind(kVerticalOfOne);
  if (at == std::string::npos) return text;
  const std::string file = text.substr(0, at);
  open.vertical_of[file] = text.substr(at + kVerticalOfOne.size());
  return file;
}

// Gives each inset its priority.
Status takeInsets(Arguments& arguments) {
  const size_t count = arguments.insets.size();
  if (const size_t given = arguments.inset_priorities.size(); given != 0 && given != count)
    return Error{ErrorCode::kInvalidArgument, "--inset-priority: " + std::to_string(given) + " priorities for " +
                                                  std::to_string(count) +
                                                  " insets; give one for each --inset, or none"};
  arguments.inset_priorities.resize(count);
  for (size_t i = 0; i < count; ++i)
    arguments.open.insets.push_back(
        {withoutVertical(arguments.insets[i], arguments.open), arguments.inset_priorities[i]});
  return {};
}

// From here on inputs and epochs are names of files.
void takeVerticals(Arguments& arguments) {
  for (std::filesystem::path& input : arguments.inputs) input = withoutVertical(input.string(), arguments.open);
  for (std::string& epoch : arguments.epochs) {
    const size_t split = epoch.find('=');
    if (split != std::string::npos && epoch.find(kVerticalOfOne) > split)
      epoch = epoch.substr(0, split + 1) + withoutVertical(epoch.substr(split + 1), arguments.open);
  }
}

int fail(const Error& error) {
  std::fprintf(stderr, "foreland build: %s\n", error.message.c_str());
  return 2;
}

// Called first, so that hours are not spent on a file that cannot be written.
Status checkOutput(const Arguments& arguments) {
  if (Status s = apps::checkOutput(arguments.output, "scene file"); !s.ok()) return s;
  for (const std::filesystem::path& input : arguments.inputs)
    if (Status s = apps::checkApart(arguments.output, input, "one of the inputs"); !s.ok()) return s;
  for (const terrain::InsetFile& inset : arguments.open.insets)
    if (Status s = apps::checkApart(arguments.output, inset.file, "one of the insets"); !s.ok()) return s;
  for (const std::filesystem::path& picture : arguments.imagery)
    if (Status s = apps::checkApart(arguments.output, picture, "one of the pictures"); !s.ok()) return s;
  return {};
}

// A twentieth of the distance between samples, rounded down to a power of ten, and never coarser than 0.1 m.
double defaultVerticalStep(double spacing_m) {
  for (const double step : {0.1, 0.01, 0.001, 0.0001})
    if (spacing_m >= 20 * step) return step;
  return 0.00001;
}

double chooseVerticalStep(const Arguments& arguments, const terrain::ElevationInfo& info) {
  if (arguments.vertical_step_m) return *arguments.vertical_step_m;
  const glm::dvec2 spacing_m = terrain::sampleSpacing(info.frame, info.width, info.height);
  const double closest_m = std::min(spacing_m.x, spacing_m.y), step_m = defaultVerticalStep(closest_m);
  if (step_m < 0.1)
    std::fprintf(stderr, "samples lie %.3g m apart, so heights are stored as multiples of %g m (--vertical-step)\n",
                 closest_m, step_m);
  return step_m;
}

void describeInput(const terrain::ElevationInfo& info) {
  const glm::dvec2 spacing_m = terrain::sampleSpacing(info.frame, info.width, info.height);
  std::fprintf(stderr, "%s: %u x %u samples, %.4g x %.4g m apart, %s\n", info.title.c_str(), info.width, info.height,
               spacing_m.x, spacing_m.y, info.frame.kind == proto::FrameKind::kPlanar ? "planar" : "geographic");
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
  terrain::OpenOptions open = arguments.open;
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
  std::vector<std::filesystem::path> files = arguments.inputs;
  for (const terrain::InsetFile& inset : arguments.open.insets) files.push_back(inset.file);
  files.insert(files.end(), arguments.imagery.begin(), arguments.imagery.end());
  for (const std::string& text : arguments.epochs) files.emplace_back(text.substr(text.find('=') + 1));
  for (const std::string& text : arguments.objects) files.emplace_back(text.substr(0, text.rfind('@')));
  for (const auto& choice : {arguments.open.vertical, arguments.open.scene_vertical})
    if (choice) files.emplace_back(*choice);
  for (const auto& [input, choice] : arguments.open.vertical_of) files.emplace_back(choice);
  std::erase_if(files, [](const std::filesystem::path& file) { return terrain::isNamedDatum(file.string()); });
  return files;
}

// As an option would say it; empty if nothing is stated, or no option can say it.
std::string verticalOfScene(const Arguments& arguments, const terrain::ElevationInfo& info) {
  if (info.vertical.name.empty()) return {};
  if (arguments.open.scene_vertical) return *arguments.open.scene_vertical;
  const auto own = arguments.open.vertical_of.find(arguments.inputs.front().string());
  const auto choice = own != arguments.open.vertical_of.end() ? std::optional(own->second) : arguments.open.vertical;
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
  if (arguments.open.residual_m) return refused("--residual");
  if (arguments.open.scene_vertical && *arguments.open.scene_vertical != terrain::kEllipsoidName)
    return Error{ErrorCode::kInvalidArgument, "--scene-vertical " + *arguments.open.scene_vertical +
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
  terrain::OpenOptions open = arguments.open;
  open.scene_vertical.reset();
  const auto source = terrain::openGlobe(arguments.inputs, open);
  if (!source.ok()) return fail(source.error());
  const auto depth = terrain::depthOf((*source)->info());
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
                                .height_quantum_m = arguments.vertical_step_m.value_or(0.1),
                                .threads = arguments.threads,
                                .page_coding = arguments.page_coding,
                                .objects = *objects,
                                .picture = picture.get(),
                                .imagery_quality = arguments.imagery_quality,
                                .attribution = arguments.attribution},
                               progress);
  });
}

int build(const Arguments& arguments) {
  const Clock::time_point begun = Clock::now();
  if (Status s = checkOutput(arguments); !s.ok()) return fail(s.error());
  auto objects = parseObjects(arguments.objects);
  if (!objects.ok()) return fail(objects.error());
  auto of_poses = epochsOfPoses(*objects);
  if (!of_poses.ok()) return fail(of_poses.error());
  terrain::OpenOptions open = arguments.open;
  // What changes in time has heights everywhere.
  if (!arguments.epochs.empty() || !of_poses->empty()) open.lattice = terrain::LatticeChoice::kWhole;
  auto source = terrain::openElevation(arguments.inputs, open);
  if (!source.ok()) return fail(source.error());
  describeInput((*source)->info());
  terrain::BuildOptions options{.output = arguments.output,
                                .height_quantum_m = chooseVerticalStep(arguments, (*source)->info()),
                                .threads = arguments.threads,
                                .page_coding = arguments.page_coding,
                                .widen_quantum = !arguments.vertical_step_m,
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
  return runBuild(arguments, begun,
                  [&](const terrain::Progress& progress) { return terrain::buildScene(**source, options, progress); });
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{"Makes a scene file from elevation data.", "foreland build"};
  Arguments arguments;
  describeElevation(app, arguments);
  describeImagery(app, arguments);
  describeChanges(app, arguments);
  apps::addForeignFiles(app, arguments.foreign);
  const auto exit_code = apps::parseCommandLine(
      app, argc, argv,
      {{"one file", "foreland build hills.tif -o hills.fls"},
       {"a survey in the coarse ground around it",
        "foreland build alps.tif --inset survey.tif --feather 50 -o alps.fls"},
       {"a whole planet, finer where a survey is",
        "foreland build etopo20.cdf --globe --vertical egm96 --inset alps.tif -o planet.fls"},
       {"a tower on a summit, twice as large as modelled and facing east",
        "foreland build N46E008.hgt -o alps.fls --object tower.fls@46.5900,8.1183,0,90,2"},
       {"ground that changes in time",
        "foreland build msh.tif --epoch 2000-09-25=01.tif --epoch 2004-10-04=02.tif -o dome.fls"}});
  if (exit_code) return *exit_code;
  takeVerticals(arguments);
  if (Status s = takeInsets(arguments); !s.ok()) return fail(s.error());
  arguments.open.allowed_folders = arguments.foreign.allowed;
  apps::confineTo(arguments.foreign, filesOf(arguments), {arguments.output});
  apps::catchStopSignals();
  return arguments.is_globe ? buildGlobe(arguments) : build(arguments);
}
