#include "apps/render/render_options.h"

#include <CLI/CLI.hpp>
#include <cstdio>
#include <regex>

#include "apps/options/command_line.h"
#include "apps/options/date.h"
#include "apps/options/lens_option.h"
#include "apps/options/options.h"
#include "apps/options/output_file.h"
#include "apps/options/tour_option.h"

namespace foreland::apps {

namespace {

constexpr const char* kFooter = R"(
POSE is LAT,LON,HEIGHT[,HEADING[,PITCH]]: degrees (x and y of the map in metres, if the scene is planar), metres above the
ground (of all dates the highest), degrees clockwise from north (0), degrees above the horizon (0).

Channels of an .exr file, one value a pixel, each for the ray through its middle:
  R, G, B               colour, linear
  depth.Z               metres along the direction of view; infinite in the sky
  normal.X, .Y, .Z      of the triangle, in the scene's frame
  id.node               slot of the terrain's node that is the nearest corner of the triangle hit; 4294967295: none
  id.object             0 the terrain, 1 the first object, ...; 4294967295 the sky
  error.px              with --error: how far from the true point the section for this pose draws it, in pixels on the screen;
                        not a number in the sky
A .png file shows the colours, or with --error the errors: yellow is --tau, red is more.

Exit code: 0 when all was written, 2 otherwise; no picture is left half-written.)";

// The place of a number in a name: "frame_%04d.png".
const std::regex& numberPattern() {
  static const std::regex pattern("%(0([1-9]))?d");
  return pattern;
}

Error invalid(std::string message) { return {ErrorCode::kInvalidArgument, std::move(message)}; }

Status checkPicture(const std::filesystem::path& output, bool is_sequence) {
  const std::string name = output.filename().string(), suffix = output.extension().string();
  if (suffix != ".exr" && suffix != ".png")
    return Error{ErrorCode::kUnsupported,
                 output.string() + ": the name must end in .exr or .png, which says the format"};
  const std::string plain = std::regex_replace(name, numberPattern(), "", std::regex_constants::format_first_only);
  if (plain.find('%') != std::string::npos)
    return invalid(output.string() + ": % stands for a frame's number, once, as in frame_%04d" + suffix);
  if (is_sequence && plain == name)
    return invalid(output.string() + ": a sequence needs a number in the name, as in frame_%04d" + suffix);
  return checkOutput(output, "picture");
}

Status check(RenderOptions& o) {
  const bool is_sequence = o.track || o.tour;
  if (!o.pose && !is_sequence) return invalid("from where? give --pose, --tour or --track");
  for (const std::filesystem::path& output : o.outputs)
    if (Status s = checkPicture(output, is_sequence); !s.ok()) return s;
  if (o.viewshed.from && o.errors == Errors::kMeasured)
    return invalid("--viewshed and --error both colour the picture; give one of them");
  o.track_options.seconds = o.seconds;
  const Result<proto::Lens> lens = parseLens(o.viewport, o.fov_deg);
  if (!lens.ok()) return lens.error();
  o.lens = *lens;
  return {};
}

struct SceneTimeTexts {
  std::optional<std::string> from, speed;
};

void addPlaces(CLI::App& app, RenderOptions& o) {
  const auto add = [&](const char* name, auto& value, const char* what) {
    return app.add_option(name, value, what)->group("From where");
  };
  CLI::Option* pose = add("--pose", o.pose, "one picture from here");
  pose->type_name(text("LAT,LON,HEIGHT[,HEADING[,PITCH]]"));
  CLI::Option* track =
      add("--track", o.track, "pictures along this recorded track: an IGC, GPX, KML or GeoJSON file, or camera frames")
          ->type_name(file("FILE"))
          ->excludes(pose);
  CLI::Option* tour = add("--tour", o.tour, "pictures along a built-in tour")
                          ->type_name(text("NAME"))
                          ->check(tourName())
                          ->excludes(pose)
                          ->excludes(track);
  add("--every", o.every_s, "seconds between the pictures of a track or tour")
      ->type_name(number("S"))
      ->check(within(0.001, 86'400.0))
      ->excludes(pose)
      ->capture_default_str();
  add("--seconds", o.seconds, "length of the flight; by default 60 for tours, the whole track")
      ->type_name(number("S"))
      ->check(above(0, 86'400))
      ->excludes(pose);
  add("--speed", o.track_options.speed, "seconds of the track per second of flight")
      ->type_name(number("X"))
      ->check(isFinite())
      ->excludes(pose)
      ->excludes(tour)
      ->capture_default_str();
  add("--from", o.track_options.from_s, "begin so many seconds into the track")
      ->type_name(number("S"))
      ->check(isFinite())
      ->excludes(pose)
      ->excludes(tour)
      ->capture_default_str();
  add("--agl", o.track_options.agl_m, "fly at least this many metres above ground, not at the recorded height")
      ->type_name(number("M"))
      ->check(isFinite())
      ->excludes(pose)
      ->excludes(tour);
}

void addSceneTime(CLI::App& app, SceneTimeTexts& texts) {
  app.add_option("--scene-from", texts.from,
                 "in scenes that change in time: the date of the (first) picture; by default the first")
      ->type_name(text("YYYY-MM-DD"))
      ->group("From where");
  app.add_option("--scene-speed", texts.speed,
                 "and how fast the scene's time goes along a track or tour, for example 90d/s; by default it stands")
      ->type_name(text("SPEED"))
      ->excludes(app.get_option("--pose"))
      ->group("From where");
}

void addViewshed(CLI::App& app, RenderOptions& o) {
  const std::string group = "What is seen";
  CLI::Option* viewshed =
      app.add_option("--viewshed", o.viewshed.from,
                     "tint what is seen from here green, and darken what is hidden from there (foreland viewshed)")
          ->type_name(text("LAT,LON,HEIGHT"))
          ->group(group);
  addViewshedOptions(app, o.viewshed, group);
  for (const char* name : {"--radius", "--target", "--refraction"}) app.get_option(name)->needs(viewshed);
}

struct Flags {
  bool is_section = false, is_full = false, wants_errors = false, wants_progress = false;
};

void addPicture(CLI::App& app, RenderOptions& o, Flags& flags) {
  const std::string group = "The picture";
  CLI::Option* section =
      app.add_flag("--section", flags.is_section, "draw the section for the pose, as a viewer would")->group(group);
  app.add_flag("--full", flags.is_full, "draw every sample and all objects in full, as without --section")
      ->excludes(section)
      ->group(group);
  app.add_flag("--error", flags.wants_errors,
               "measure how far, on the screen, the section draws each visible point from where it truly is")
      ->group(group);
  app.add_option("--tau", o.tau_px, "tolerance of sections in pixels")
      ->type_name(number("PX"))
      ->check(above(0, 1000))
      ->capture_default_str()
      ->group(group);
  app.add_option("--viewport", o.viewport, "size in pixels")
      ->type_name(text("WxH"))
      ->capture_default_str()
      ->group(group);
  app.add_option("--fov", o.fov_deg, "vertical field of view in degrees")
      ->type_name(number("DEG"))
      ->check(within(1.0, 170.0))
      ->capture_default_str()
      ->group(group);
  app.add_flag("--progress", flags.wants_progress, "show progress though standard error is no terminal")->group(group);
}

const std::vector<Example> kExamples{
    {"one picture", "foreland render hills.fls --pose 5000,-15000,500,45,-10 --viewport 1280x720 -o render.png"},
    {"a minute of a tour, as a viewer would see it, four pictures a second",
     "foreland render hills.fls --tour canyon --section --every 0.25 -o frame_%04d.png"}};

}  // namespace

ParsedRenderOptions parseRenderOptions(int argc, const char* const* argv) {
  RenderOptions o;
  Flags flags;
  CLI::App app("Makes reference pictures of a scene by ray casting.", "foreland render");
  app.footer(kFooter);
  app.add_option("SCENE", o.scene, "the scene file")->type_name(file("SCENE.fls"))->required();
  app.add_option("-o,--output", o.outputs, "the picture, OpenEXR or PNG by its name")
      ->type_name(file("PICTURE.exr|PICTURE.png"))
      ->required();
  addPlaces(app, o);
  SceneTimeTexts scene_time;
  addSceneTime(app, scene_time);
  addPicture(app, o, flags);
  addViewshed(app, o);
  if (const auto exit_code = parseCommandLine(app, argc, argv, kExamples)) return {{}, exit_code};
  o.drawn = flags.is_section ? Drawn::kSection : Drawn::kFull;
  o.errors = flags.wants_errors ? Errors::kMeasured : Errors::kNone;
  o.progress = flags.wants_progress ? Progress::kAlways : Progress::kOnTerminals;
  Status checked = check(o);
  if (auto clock = parseSceneClock(scene_time.from, scene_time.speed); !clock.ok())
    checked = clock.error();
  else
    o.scene_clock = *clock;
  if (!checked.ok()) {
    std::fprintf(stderr, "foreland render: %s\n", checked.error().message.c_str());
    return {{}, 2};
  }
  return {std::move(o), std::nullopt};
}

std::filesystem::path numbered(const std::filesystem::path& pattern, size_t number) {
  const std::string name = pattern.filename().string();
  std::smatch found;
  if (!std::regex_search(name, found, numberPattern())) return pattern;
  std::string digits = std::to_string(number);
  const size_t width = found[2].matched ? static_cast<size_t>(std::stoi(found[2])) : 1;
  if (digits.size() < width) digits.insert(0, width - digits.size(), '0');
  return pattern.parent_path() / (found.prefix().str() + digits + found.suffix().str());
}

}  // namespace foreland::apps
