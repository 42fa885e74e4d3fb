// `foreland bench tiles`: its options, and the comparison that they ask for.
#pragma once

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "lab/apps/bench_experiment.h"
#include "lab/apps/bench_flight.h"
#include "lab/apps/bench_link.h"

namespace foreland::apps {

enum class Camera : uint8_t { kAsPlanned, kJumps };

struct TilesArguments {
  FlightArguments flight;
  ExperimentArguments experiment;
  LinkArguments link;
  uint32_t width_px = 1920, height_px = 1080;
  Camera camera = Camera::kAsPlanned;
};

CLI::App* addTiles(CLI::App& app, TilesArguments& args);

// Whether link and prices are usable.
Status checkArguments(const TilesArguments& args);

// Flies once with each way, writes the tables if there is a folder for it, and returns what they say.
Result<nlohmann::ordered_json> tiles(const TilesArguments& args);

}  // namespace foreland::apps
