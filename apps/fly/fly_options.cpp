#include "apps/fly/fly_options.h"

#include <CLI/CLI.hpp>
#include <string>
#include <string_view>

#include "apps/fly/fly_report.h"
#include "apps/options/command_line.h"
#include "apps/options/date.h"
#include "apps/options/foreign_track.h"
#include "apps/options/keyframe_option.h"
#include "apps/options/lens_option.h"
#include "apps/options/options.h"
#include "apps/options/tour_option.h"
#include "proto/message/keyframe_interval.h"

namespace foreland::apps {

namespace {

constexpr const char* kFlight = R"(
The flight is flown in real time at 60 frames a second. The predictor is `path` unless --predictor names another one:
the path of a tour or track is known, and is announced to the server. The tour `jumps` has no path (predictor `velocity`).
)";
constexpr const char* kExitCodes = R"(
Exit code: 0 when the flight was flown to its end, 2 otherwise.)";

Error invalid(std::string message) { return {ErrorCode::kInvalidArgument, std::move(message)}; }

Result<proto::ViewRequest> requestOf(const FlyOptions& o) {
  const Result<proto::Lens> lens = parseLens(o.viewport, o.fov_deg);
  if (!lens.ok()) return lens.error();
  const auto strategy = proto::strategyNamed(o.strategy);
  if (!strategy) return invalid("--strategy '" + o.strategy + "': choose delay, current or predict");
  const auto predictor = proto::predictorNamed(o.predictor.value_or(o.tour == "jumps" ? "velocity" : "path"));
  if (!predictor) return invalid("--predictor '" + *o.predictor + "': choose one of " + proto::predictorNames());
  const auto interval = proto::keyframeIntervalFrom(o.keyframe_ms);
  if (!interval) return invalid("--keyframe-ms: " + interval.error().message);
  return proto::ViewRequest{.lens = *lens,
                            .tau_px = o.tau_px,
                            .strategy = *strategy,
                            .predictor = *predictor,
                            .keyframe_interval = interval->shortest,
                            .longest_interval = interval->longest,
                            .max_triangles = o.max_triangles,
                            .max_bytes_per_second = o.max_kbit_per_s * 125,
                            .occlusion = o.occlusion != "off",
                            .memory_bytes = static_cast<uint32_t>(o.memory_mib * 1048576),
                            .relief = o.relief,
                            .imagery = o.imagery};
}

}  // namespace

namespace {

void addServer(CLI::App& app, FlyOptions& o) {
  app.add_option("URL", o.url, "the server, as ws://HOST:PORT or wss://HOST:PORT")->type_name(text("URL"))->required();
  app.add_option("--token", o.connection.token, "a token from `foreland token`, for a server that asks for one")
      ->type_name(text("T"));
  app.add_option("--ca", o.connection.ca_file, "certificates to trust, in PEM format, instead of the system's")
      ->type_name(file("FILE"));
}

void addCamera(CLI::App& app, FlyOptions& o) {
  const auto add = [&](const char* name, auto& value, const char* what) {
    return app.add_option(name, value, what)->group("Where the camera goes");
  };
  CLI::Option* track =
      add("--track", o.track, "fly this recorded track: an IGC, GPX, KML or GeoJSON file, or camera frames")
          ->type_name(file("FILE"));
  add("--tour", o.tour,
      "fly a built-in tour: survey (the default), canyon, spin, orbit; over a globe also descent (or "
      "descent:LAT,LON), pole, antimeridian, corner, equator; or jumps, from view to view")
      ->type_name(text("NAME"))
      ->check(tourName({"jumps"}))
      ->excludes(track);
  add("--seconds", o.seconds, "length of the flight; by default 60 for tours, the whole track")
      ->type_name(number("S"))
      ->check(above(0, 86'400));
  add("--speed", o.track_options.speed, "seconds of the track per second of flight")
      ->type_name(number("X"))
      ->check(isFinite())
      ->needs(track)
      ->capture_default_str();
  add("--from", o.track_options.from_s, "begin so many seconds into the track")
      ->type_name(number("S"))
      ->check(isFinite())
      ->needs(track)
      ->capture_default_str();
  CLI::Option* agl =
      add("--agl", o.track_options.agl_m, "fly at least this many metres above ground, not at the recorded height");
  agl->type_name(number("M"))->check(isFinite())->needs(track);
  add("--clearance", o.track_options.clearance_m, "lift recorded heights to this many metres above ground")
      ->type_name(number("M"))
      ->check(isFinite())
      ->needs(track)
      ->excludes(agl)
      ->capture_default_str();
  add("--scene-from", o.scene_from,
      "in scenes that change in time: the date that the flight begins at; by default the first")
      ->type_name(text("YYYY-MM-DD"));
  add("--scene-speed", o.scene_speed,
      "and how fast the scene's time goes, for example 90d/s; s, h, d and y are understood; by default it stands")
      ->type_name(text("SPEED"));
}

void addKeyframes(CLI::App& app, FlyOptions& o) {
  const auto add = [&](const char* name, auto& value, const char* what) {
    return app.add_option(name, value, what)->group("Keyframes");
  };
  add("--strategy", o.strategy,
      "delay: show the scene as it was, an interval late; current: the same geometry with the present camera; predict: "
      "keyframes are computed for where the camera will be")
      ->type_name(text("NAME"))
      ->check(oneOf({"delay", "current", "predict"}))
      ->capture_default_str();
  add("--predictor", o.predictor, "how the server guesses where the camera will be; path, which is known, by default")
      ->type_name(text("NAME"))
      ->check(oneOf({"hold", "velocity", "acceleration", "double-exponential", "kalman", "path"}));
  add("--blend", o.blend,
      "keyframe: all detail changes from keyframe to keyframe, within the tolerance in every frame; b-spline-2 and "
      "b-spline-3: likewise, but of the last three or four keyframes, so that nothing changes its velocity at once; "
      "geomorph: each node changes at a time of its own")
      ->type_name(text("NAME"))
      ->check(oneOf({"keyframe", "b-spline-2", "b-spline-3", "geomorph"}))
      ->capture_default_str();
  add("--keyframe-ms", o.keyframe_ms,
      "time between keyframes: 20 to 10000 milliseconds, or adaptive, or between two bounds, such as 100-500")
      ->type_name(numberOrText("MS"))
      ->check(keyframeInterval())
      ->capture_default_str();
}

void addDetail(CLI::App& app, FlyOptions& o) {
  const auto add = [&](const char* name, auto& value, const char* what) {
    return app.add_option(name, value, what)->group("What is asked for");
  };
  add("--tau", o.tau_px, "largest error on the screen in pixels")
      ->type_name(number("PX"))
      ->check(above(0, 1000))
      ->capture_default_str();
  add("--viewport", o.viewport, "size of the screen in pixels")->type_name(text("WxH"))->capture_default_str();
  add("--fov", o.fov_deg, "vertical field of view in degrees")
      ->type_name(number("DEG"))
      ->check(within(1.0, 170.0))
      ->capture_default_str();
  add("--exaggeration", o.exaggeration,
      "draw heights so many times as tall; what is drawn keeps --tau, and --truth judges it, so the server is asked "
      "for "
      "more")
      ->type_name(number("X"))
      ->check(within(client::Exaggeration::kLeast, client::Exaggeration::kMost))
      ->capture_default_str();
  add("--max-triangles", o.max_triangles, "budget: the tolerance rises to stay inside; 0: none")
      ->type_name(whole("N"))
      ->capture_default_str();
  add("--max-kbit", o.max_kbit_per_s, "budget of kbit/s down, likewise; by default none")
      ->type_name(whole("N"))
      ->check(within(1u, 8'000'000u));
  add("--memory-mib", o.memory_mib,
      "MiB to remember terrain with that was flown over, so that it is not sent again; 0: none")
      ->type_name(number("M"))
      ->check(within(0.0, 1024.0))
      ->capture_default_str();
  add("--occlusion", o.occlusion,
      "auto: be sent nothing of what is hidden, if the server finds that out; on: the same, and end with an error if "
      "it "
      "does not; --truth judges what is seen")
      ->check(oneOf({"auto", "on", "off"}))
      ->capture_default_str();
  app.add_flag("--relief", o.relief, "be sent tiles of relief, and count them; none is decoded")
      ->group("What is asked for");
  app.add_flag("--imagery", o.imagery, "be sent tiles of imagery, likewise")->group("What is asked for");
}

void addReport(CLI::App& app, FlyOptions& o) {
  addAfterwardsOptions(app, o.afterwards);
  CLI::Option* record =
      app.add_option("--record", o.record, "write all that comes in to this file, for `foreland replay`");
  record->type_name(file("FILE"))->group("The report");
  app.get_option("--exaggeration")->excludes(record)->excludes(app.get_option("--dump"));
  app.add_option("--viewers", o.viewers, "fly so many viewers at once, and report on all together")
      ->type_name(whole("N"))
      ->check(within(1, 10'000))
      ->excludes(app.get_option("--truth"))
      ->excludes(app.get_option("--dump"))
      ->excludes(record)
      ->capture_default_str()
      ->group("The report");
  app.add_flag_callback(
         "--json", [&o] { o.format = apps::ReportFormat::kJson; }, "print the report as JSON")
      ->group("The report");
}

const std::vector<Example> kExamples{
    {"a built-in tour, measured against the scene",
     "foreland fly ws://127.0.0.1:8080 --tour survey --seconds 20 --truth hills.fls"},
    {"a paraglider's track, 20 times as fast", "foreland fly ws://127.0.0.1:8080 --track flight.igc --speed 20"},
    {"through seven years of a volcano",
     "foreland fly ws://127.0.0.1:8080 --tour orbit --scene-from 2000-09-25 --scene-speed 90d/s"}};

// Flies so that what is drawn keeps the tolerance where heights are taller.
Status exaggerate(const FlyOptions& o, client::PlayerOptions& player) {
  if (o.exaggeration == 1) return {};
  if (o.tour == "jumps") return invalid("--exaggeration: the tour 'jumps' shows true heights only; choose another one");
  player.exaggeration = client::Exaggeration::of(o.exaggeration, player.request.lens);
  player.request.lens = player.exaggeration.asked;
  player.request.tau_px /= player.exaggeration.finer;
  return {};
}

}  // namespace

ParsedFlyOptions parseFlyOptions(int argc, const char* const* argv) {
  FlyOptions o;
  CLI::App app("Flies through a served scene without a screen, and reports.", "foreland fly");
  app.footer(std::string(kFlight) + reportHelp() + kExitCodes);
  addServer(app, o);
  addCamera(app, o);
  addKeyframes(app, o);
  addDetail(app, o);
  addReport(app, o);
  const auto exit_code = parseCommandLine(app, argc, argv, kExamples);
  return {std::move(o), exit_code};
}

Result<client::PlayerOptions> playerOptions(const FlyOptions& o) {
  const Result<proto::ViewRequest> request = requestOf(o);
  if (!request.ok()) return request.error();
  const std::optional<client::Blend> blend = client::blendNamed(o.blend);
  if (!blend) return invalid("--blend '" + o.blend + "': choose keyframe, geomorph, b-spline-2 or b-spline-3");
  if (client::orderOf(*blend) > 1 && request->longest_interval != Duration{})
    return invalid("--blend " + o.blend + " with --keyframe-ms " + o.keyframe_ms +
                   ": a spline of several keyframes needs equal intervals; name one, for example 200");
  if (o.tour == "jumps" && request->predictor == proto::Predictor::kKnownPath)
    return invalid("--predictor path: the tour 'jumps' has no path; choose hold, velocity or acceleration");
  const auto scene = parseSceneClock(o.scene_from, o.scene_speed);
  if (!scene.ok()) return scene.error();
  if (client::orderOf(*blend) > 1 && *scene && (*scene)->rate != 0)
    return invalid(
        "--blend " + o.blend +
        " with --scene-speed: a node that leaves a section is drawn for some keyframes more, and where it is "
        "at the next date is not sent any more; fly with --blend keyframe, or let the scene stand");
  client::PlayerOptions player{.request = *request,
                               .blend = *blend,
                               .knowledge = request->predictor == proto::Predictor::kKnownPath
                                                ? client::PathKnowledge::kAnnounced
                                                : client::PathKnowledge::kPrivate,
                               .tour = o.tour.value_or("survey"),
                               .track = nullptr,
                               .track_options = o.track_options,
                               .scene = *scene,
                               .seconds = o.seconds.value_or(60)};
  player.track_options.seconds = o.seconds;
  if (Status s = exaggerate(o, player); !s.ok()) return s.error();
  if (!o.track) return player;
  Result<client::Track> track = readForeignTrack(*o.track);
  if (!track.ok()) return track.error();
  player.track = std::make_shared<const client::Track>(std::move(track).value());
  return player;
}

}  // namespace foreland::apps
