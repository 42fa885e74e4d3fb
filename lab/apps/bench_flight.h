// The flight that `foreland bench` measures: its options, and the path that they ask for.
#pragma once

#include <CLI/CLI.hpp>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "apps/report/report.h"
#include "base/fnv1a.h"
#include "base/result.h"
#include "client/fly/track_path.h"
#include "lab/sections/flight_views.h"
#include "server/section/hierarchy.h"

namespace foreland::apps {

struct FlightArguments {
  std::string scene, tour = "survey";
  std::filesystem::path track;  // empty: the tour
  client::TrackOptions track_options;
  lab::FlightOptions flight;
  double keyframe_ms = 200;
  apps::ReportFormat format = apps::ReportFormat::kText;
};

// The scene, the path over it, how long it is flown, and --json. Fills `args` when the command line is parsed.
void addPathOptions(CLI::App& app, FlightArguments& args);
// The same, with a tolerance and a keyframe interval.
void addFlightOptions(CLI::App& app, FlightArguments& args);
// --width and --height.
void addScreenOptions(CLI::App& app, uint32_t& width_px, uint32_t& height_px);

struct PlannedFlight {
  std::shared_ptr<const terrain::Scene> scene;
  proto::Path path;
  lab::FlightOptions options;  // `seconds` is at most the path's length
};

// Opens the scene and plans the tour over it, or the track as `foreland fly` would fly it. Prints what has been noted
// about a track on stderr.
Result<PlannedFlight> planFlight(const FlightArguments& args);

// The same, for what measures planes alone: an Error over a globe, which says so.
Result<PlannedFlight> planFlightOverPlane(const FlightArguments& args);

// The scene's terrain and objects.
Result<server::Hierarchy> hierarchyOf(const std::shared_ptr<const terrain::Scene>& scene);

// Adds the path, for the name of a file that it was read from says too little.
void addPath(const proto::Path& path, Fnv1a& hash);

// What was flown: the first figures of every report.
nlohmann::ordered_json flightReport(const FlightArguments& args, const PlannedFlight& flight);

}  // namespace foreland::apps
