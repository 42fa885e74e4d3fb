#include "lab/apps/bench_flight.h"

#include <bit>
#include <cstdio>
#include <limits>
#include <utility>

#include "apps/options/options.h"
#include "apps/options/tour_option.h"
#include "client/fly/recorded_path.h"
#include "client/fly/tracks/track.h"
#include "server/view/ground.h"
#include "server/view/tour.h"

namespace foreland::apps {

namespace {

void addTrackOptions(CLI::App& app, FlightArguments& args) {
  const auto add = [&](const char* name, auto& value, const char* what) {
    return app.add_option(name, value, what)->group("The path");
  };
  CLI::Option* tour =
      add("--tour", args.tour, "a built-in tour")->type_name(text("NAME"))->check(tourName())->capture_default_str();
  CLI::Option* track = add("--track", args.track,
                           "fly this recorded track: an IGC, GPX, KML or GeoJSON file, camera frames, or what "
                           "`foreland fly --record` wrote")
                           ->type_name(file("FILE"))
                           ->excludes(tour);
  add("--from", args.track_options.from_s, "begin so many seconds into the track")
      ->type_name(number("S"))
      ->check(isFinite())
      ->needs(track)
      ->capture_default_str();
  add("--speed", args.track_options.speed, "seconds of the track per second of flight")
      ->type_name(number("X"))
      ->check(isFinite())
      ->needs(track)
      ->capture_default_str();
  add("--agl", args.track_options.agl_m, "fly at least this many metres above ground, not at the recorded height")
      ->type_name(number("M"))
      ->check(isFinite())
      ->needs(track);
}

Result<proto::Path> planRecording(const terrain::Scene& scene, const FlightArguments& args,
                                  const client::TrackOptions& options) {
  auto recorded = client::readRecordedPath(args.track, options);
  if (!recorded) return recorded.error();
  if (recorded->scene_id != scene.id())
    return Error{ErrorCode::kInvalidArgument, args.track.string() + " was recorded over another scene than " +
                                                  args.scene + "; name that one's file"};
  return std::move(recorded->path);
}

Result<proto::Path> planTrack(const terrain::Scene& scene, const FlightArguments& args) {
  client::TrackOptions options = args.track_options;
  options.seconds = args.flight.seconds + 1;
  if (client::isRecording(args.track)) return planRecording(scene, args, options);
  const auto track = client::readTrack(args.track);
  if (!track) return track.error();
  const proto::FrameTransform frame(scene.frame());
  auto plan = client::planTrack(*track, frame, scene.grid().shape(), options);
  if (!plan) return plan.error();
  plan->undulations_m = server::seaAboveZero(scene, plan->positions);
  std::vector<float> ground_m;
  for (const glm::dvec2& at : plan->positions)
    ground_m.push_back(
        static_cast<float>(server::groundHeight(scene, at.x, at.y).value_or(std::numeric_limits<double>::quiet_NaN())));
  const auto flown = client::pathOverGround(*plan, frame, ground_m, options);
  if (!flown) return flown.error();
  for (const std::vector<std::string>* notes : {&track->notes, &std::as_const(plan->notes), &flown->notes})
    for (const std::string& note : *notes) std::fprintf(stderr, "note: %s\n", note.c_str());
  return flown->path;
}

}  // namespace

void addScreenOptions(CLI::App& app, uint32_t& width_px, uint32_t& height_px) {
  for (const auto& [name, size] : {std::pair<const char*, uint32_t&>{"--width", width_px}, {"--height", height_px}})
    app.add_option(name, size, "of the screen, in pixels")
        ->type_name(whole("PX"))
        ->check(within(16, 8192))
        ->capture_default_str()
        ->group("The screen");
}

void addPathOptions(CLI::App& app, FlightArguments& args) {
  app.add_option("SCENE", args.scene, "scene file (`foreland build`)")->type_name(file("SCENE.fls"))->required();
  addTrackOptions(app, args);
  app.add_option("--seconds", args.flight.seconds, "of flight")
      ->type_name(number("S"))
      ->check(within(1.0, 3600.0))
      ->capture_default_str();
  app.add_flag_callback(
      "--json", [&args] { args.format = apps::ReportFormat::kJson; }, "print JSON");
}

void addFlightOptions(CLI::App& app, FlightArguments& args) {
  addPathOptions(app, args);
  app.add_option("--tau", args.flight.tau_px, "tolerance in pixels")
      ->type_name(number("PX"))
      ->check(within(0.01, 1000.0))
      ->capture_default_str();
  app.add_option("--keyframe-ms", args.keyframe_ms, "keyframe interval")
      ->type_name(number("MS"))
      ->check(within(20.0, 10'000.0))
      ->capture_default_str();
}

Result<PlannedFlight> planFlight(const FlightArguments& args) {
  auto scene = terrain::Scene::open(args.scene);
  if (!scene) return scene.error();
  auto path =
      args.track.empty() ? server::planTour(**scene, args.tour, args.flight.seconds + 1) : planTrack(**scene, args);
  if (!path) return path.error();
  PlannedFlight flight{*scene, std::move(*path), args.flight};
  flight.options.keyframe_interval = Duration::seconds(args.keyframe_ms / 1000);
  const double path_s = flight.path.step.toSeconds() * static_cast<double>(flight.path.poses.size() - 1);
  flight.options.seconds = std::min(flight.options.seconds, path_s);
  return flight;
}

Result<PlannedFlight> planFlightOverPlane(const FlightArguments& args) {
  auto flight = planFlight(args);
  if (flight.ok() && flight->scene->grid().isCube())
    return Error{ErrorCode::kUnsupported,
                 args.scene +
                     ": a globe, and what is compared here are squares of a plane; over globes "
                     "there are sections, keyframes, wire, client, load, and occlusion with --judge 0"};
  return flight;
}

Result<server::Hierarchy> hierarchyOf(const std::shared_ptr<const terrain::Scene>& scene) {
  auto objects = server::objectsOf(scene);
  if (!objects) return objects.error();
  return server::Hierarchy(scene, proto::ErrorBound::kSpheroid, std::move(*objects));
}

void addPath(const proto::Path& path, Fnv1a& hash) {
  const auto add = [&](double value) { hash.addWord(std::bit_cast<uint64_t>(value)); };
  for (const proto::Pose& pose : path.poses) {
    for (int i = 0; i < 3; ++i) add(pose.eye[i]);
    for (int i = 0; i < 4; ++i) add(pose.orientation[i]);
  }
}

nlohmann::ordered_json flightReport(const FlightArguments& args, const PlannedFlight& flight) {
  nlohmann::ordered_json report;
  if (args.track.empty())
    report["tour"] = args.tour;
  else
    report.update({{"track", args.track.filename().string()},
                   {"from_s", args.track_options.from_s},
                   {"speed", args.track_options.speed}});
  report.update({{"tau_px", flight.options.tau_px},
                 {"keyframe_ms", flight.options.keyframe_interval.toMilliseconds()},
                 {"seconds", flight.options.seconds}});
  return report;
}

}  // namespace foreland::apps
