#include "apps/build/elevation_options.h"

#include <algorithm>
#include <cstdio>
#include <glm/vec2.hpp>
#include <map>

#include "apps/options/options.h"
#include "terrain/dem/vertical/height_reference.h"
#include "terrain/geo/geodesy.h"

namespace foreland::apps {

namespace {

void describeInsets(CLI::App& app, ElevationArguments& arguments) {
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

// A twentieth of the distance between samples, rounded down to a power of ten, and never coarser than 0.1 m.
double defaultVerticalStep(double spacing_m) {
  for (const double step : {0.1, 0.01, 0.001, 0.0001})
    if (spacing_m >= 20 * step) return step;
  return 0.00001;
}

}  // namespace

void describeInputs(CLI::App& app, ElevationArguments& arguments) {
  app.add_option(
         "INPUT", arguments.inputs,
         "elevation files: whatever GDAL reads (GeoTIFF, HGT, zipped too, ASCII grid, netCDF, USGS DEM, PNG), or "
         "OpenEXR height maps; several make a mosaic")
      ->type_name(apps::file("INPUT"))
      ->required();
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
}

std::string withoutVertical(const std::string& text, terrain::OpenOptions& open) {
  const size_t at = text.rfind(kVerticalOfOne);
  if (at == std::string::npos) return text;
  const std::string file = text.substr(0, at);
  open.vertical_of[file] = text.substr(at + kVerticalOfOne.size());
  return file;
}

void takeVerticals(ElevationArguments& arguments) {
  for (std::filesystem::path& input : arguments.inputs) input = withoutVertical(input.string(), arguments.open);
}

Status takeInsets(ElevationArguments& arguments) {
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

std::vector<std::filesystem::path> filesOf(const ElevationArguments& arguments) {
  std::vector<std::filesystem::path> files = arguments.inputs;
  for (const terrain::InsetFile& inset : arguments.open.insets) files.push_back(inset.file);
  for (const auto& choice : {arguments.open.vertical, arguments.open.scene_vertical})
    if (choice) files.emplace_back(*choice);
  for (const auto& [input, choice] : arguments.open.vertical_of) files.emplace_back(choice);
  std::erase_if(files, [](const std::filesystem::path& file) { return terrain::isNamedDatum(file.string()); });
  return files;
}

double chooseVerticalStep(const ElevationArguments& arguments, const terrain::ElevationInfo& info) {
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

}  // namespace foreland::apps
