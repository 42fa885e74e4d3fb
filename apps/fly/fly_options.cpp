#include "apps/fly/fly_options.h"

#include <CLI/CLI.hpp>
#include <string>
#include <string_view>

#include "apps/date.h"
#include "apps/fly/fly_report.h"
#include "apps/lens_option.h"
#include "apps/options.h"
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
  if (!(o.tau_px > 0) || o.tau_px > 1000) return invalid("--tau must be above 0 and at most 1000 pixels");
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
                            .occlusion = o.occlusion == "on",
                            .memory_bytes = static_cast<uint32_t>(o.memory_mib * 1048576),
                            .relief = o.relief,
                            .imagery = o.imagery};
}

}  // namespace

ParsedFlyOptions parseFlyOptions(int argc, const char* const* argv) {
  FlyOptions o;
  CLI::App app("Fly through a served scene without a screen, and report.", "foreland fly");
  app.footer(std::string(kFlight) + reportHelp() + kExitCodes);
  app.add_option("URL", o.url, "the server, as ws://HOST:PORT or wss://HOST:PORT")->required();
  app.add_option("--token", o.connection.token, "a token from `foreland token`, for a server that asks for one");
  app.add_option("--ca", o.connection.ca_file, "certificates to trust, in PEM format, instead of the system's");
  CLI::Option* track =
      app.add_option("--track", o.track, "fly this recorded track: an IGC or GPX file, or camera frames");
  app.add_option("--tour", o.tour,
                 "fly a built-in tour: survey (default), canyon, spin, orbit; or jumps, from view to view")
      ->excludes(track);
  app.add_option("--seconds", o.seconds, "length of the flight (default: 60 for tours, the whole track)")
      ->check(isFinite());
  app.add_option("--speed", o.track_options.speed, "seconds of the track per second of flight (default 1)")
      ->check(isFinite())
      ->needs(track);
  app.add_option("--from", o.track_options.from_s, "begin so many seconds into the track")
      ->check(isFinite())
      ->needs(track);
  CLI::Option* agl = app.add_option("--agl", o.track_options.agl_m,
                                    "fly at least this many metres above ground, not at the recorded height");
  agl->check(isFinite())->needs(track);
  app.add_option("--clearance", o.track_options.clearance_m,
                 "lift recorded heights to this many metres above ground (default 20)")
      ->check(isFinite())
      ->needs(track)
      ->excludes(agl);
  app.add_option("--strategy", o.strategy, "delay, current or predict (default)");
  app.add_option("--blend", o.blend,
                 "keyframe (default): all detail changes from keyframe to keyframe, within the tolerance in every "
                 "frame; b-spline-2 and b-spline-3: likewise, but of the last three or four keyframes, so that nothing "
                 "changes its velocity at once; geomorph: each node changes at a time of its own");
  app.add_option("--occlusion", o.occlusion,
                 "on: ask for sections without what ridges hide, of a server with --occlusion on (default off)")
      ->check(CLI::IsMember({"on", "off"}));
  app.add_flag("--relief", o.relief, "be sent tiles of relief, and count them; none is decoded");
  app.add_flag("--imagery", o.imagery, "be sent tiles of imagery, likewise");
  app.add_option("--predictor", o.predictor,
                 "hold, velocity, acceleration, double-exponential, kalman or path (default)");
  app.add_option("--tau", o.tau_px, "tolerance in pixels (default 1)")->check(isFinite());
  app.add_option("--keyframe-ms", o.keyframe_ms,
                 "time between keyframes: 20 to 10000, or adaptive, or 100-500 (default 200)");
  app.add_option("--memory-mib", o.memory_mib,
                 "MiB to remember terrain with that was flown over, so that it is not sent again (default 16)")
      ->check(CLI::Range(0.0, 1024.0) & isFinite());
  app.add_option("--max-triangles", o.max_triangles, "budget: the tolerance rises to stay inside (default none)");
  app.add_option("--max-kbit", o.max_kbit_per_s, "budget of kbit/s down, likewise (default none)")
      ->check(CLI::Range(1u, 8'000'000u));
  app.add_option("--viewport", o.viewport, "WIDTHxHEIGHT in pixels (default 1920x1080)");
  app.add_option("--fov", o.fov_deg, "vertical field of view in degrees (default 60)")->check(isFinite());
  app.add_option("--scene-from", o.scene_from,
                 "in scenes that change in time: the date that the flight begins at, YYYY-MM-DD (default: the first)");
  app.add_option("--scene-speed", o.scene_speed,
                 "and how fast the scene's time goes, for example 90d/s; s, h, d and y are understood (default 0d/s)");
  addAfterwardsOptions(app, o.afterwards);
  CLI::Option* record =
      app.add_option("--record", o.record, "write all that comes in to this file, for `foreland replay`");
  app.add_option("--viewers", o.viewers, "fly so many viewers at once, and report on all together (default 1)")
      ->check(CLI::Range(1, 10'000))
      ->excludes(app.get_option("--truth"))
      ->excludes(app.get_option("--dump"))
      ->excludes(record);
  app.add_flag_callback(
      "--json", [&o] { o.format = apps::ReportFormat::kJson; }, "print the report as JSON");
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& e) { return {std::move(o), app.exit(e) == 0 ? 0 : 2}; }
  return {std::move(o), std::nullopt};
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
  if (o.seconds && (!(*o.seconds > 0) || *o.seconds > 86'400))
    return invalid("--seconds must be above 0 and at most 86400");
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
  if (!o.track) return player;
  Result<client::Track> track = client::readTrack(*o.track);
  if (!track.ok()) return track.error();
  player.track = std::make_shared<const client::Track>(std::move(track).value());
  return player;
}

}  // namespace foreland::apps
