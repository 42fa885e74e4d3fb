#include "apps/render_options.h"

#include <CLI/CLI.hpp>
#include <cstdio>
#include <regex>

#include "apps/date.h"
#include "apps/lens_option.h"
#include "apps/options.h"
#include "apps/output_file.h"

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
  if (!(o.tau_px > 0) || o.tau_px > 1000) return invalid("--tau must be above 0 and at most 1000 pixels");
  if (!(o.every_s >= 0.001) || o.every_s > 86'400) return invalid("--every must be 0.001 to 86400 seconds");
  if (o.seconds && (!(*o.seconds > 0) || *o.seconds > 86'400))
    return invalid("--seconds must be above 0 and at most 86400");
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
  CLI::Option* pose = app.add_option("--pose", o.pose, "one picture from here: LAT,LON,HEIGHT[,HEADING[,PITCH]]");
  CLI::Option* track =
      app.add_option("--track", o.track, "pictures along this recorded track: an IGC or GPX file, or camera frames")
          ->excludes(pose);
  CLI::Option* tour = app.add_option("--tour", o.tour, "pictures along a built-in tour: survey, canyon, spin, orbit")
                          ->excludes(pose)
                          ->excludes(track);
  app.add_option("--every", o.every_s, "seconds between the pictures of a track or tour (default 1)")
      ->check(isFinite())
      ->excludes(pose);
  app.add_option("--seconds", o.seconds, "length of the flight (default: 60 for tours, the whole track)")
      ->check(isFinite())
      ->excludes(pose);
  app.add_option("--from", o.track_options.from_s, "begin so many seconds into the track")
      ->check(isFinite())
      ->excludes(pose)
      ->excludes(tour);
  app.add_option("--agl", o.track_options.agl_m,
                 "fly at least this many metres above ground, not at the recorded height")
      ->check(isFinite())
      ->excludes(pose)
      ->excludes(tour);
}

void addSceneTime(CLI::App& app, SceneTimeTexts& texts) {
  app.add_option("--scene-from", texts.from,
                 "in scenes that change in time: the date of the (first) picture, YYYY-MM-DD (default: the first)");
  app.add_option("--scene-speed", texts.speed,
                 "and how fast the scene's time goes along a track or tour, for example 90d/s (default 0d/s)")
      ->excludes(app.get_option("--pose"));
}

}  // namespace

ParsedRenderOptions parseRenderOptions(int argc, const char* const* argv) {
  RenderOptions o;
  bool is_section = false, is_full = false, wants_errors = false, wants_progress = false;
  CLI::App app("Make reference pictures of a scene by ray casting.", "foreland render");
  app.footer(kFooter);
  app.add_option("SCENE", o.scene, "the scene file")->required();
  app.add_option("-o,--output", o.outputs, "the picture, .exr or .png; may be given more than once")->required();
  addPlaces(app, o);
  SceneTimeTexts scene_time;
  addSceneTime(app, scene_time);
  CLI::Option* section = app.add_flag("--section", is_section, "draw the section for the pose, as a viewer would");
  app.add_flag("--full", is_full, "draw every sample and all objects in full (default)")->excludes(section);
  app.add_flag("--error", wants_errors, "measure the section for the pose against the full resolution");
  app.add_option("--tau", o.tau_px, "tolerance of sections in pixels (default 1)")->check(isFinite());
  app.add_option("--viewport", o.viewport, "WIDTHxHEIGHT in pixels (default 1920x1080)");
  app.add_option("--fov", o.fov_deg, "vertical field of view in degrees (default 60)")->check(isFinite());
  app.add_flag("--progress", wants_progress, "show progress though standard error is no terminal");
  try {
    app.parse(argc, argv);
  } catch (const CLI::Success& asked) { return {{}, app.exit(asked)}; } catch (const CLI::ParseError& error) {
    std::fprintf(stderr, "foreland render: %s (see foreland render --help)\n", error.what());
    return {{}, 2};
  }
  o.drawn = is_section ? Drawn::kSection : Drawn::kFull;
  o.errors = wants_errors ? Errors::kMeasured : Errors::kNone;
  o.progress = wants_progress ? Progress::kAlways : Progress::kOnTerminals;
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
