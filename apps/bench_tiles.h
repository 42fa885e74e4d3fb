// `foreland bench tiles`: its options, and the comparison that they ask for.
#pragma once

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>
#include <string>

#include "apps/bench_experiment.h"
#include "apps/bench_flight.h"

namespace foreland::apps {

enum class Camera : uint8_t { kAsPlanned, kJumps };

struct TilesArguments {
  FlightArguments flight;
  ExperimentArguments experiment;
  std::string link = "wifi";
  uint32_t width_px = 1920, height_px = 1080;
  Camera camera = Camera::kAsPlanned;
};

CLI::App* addTiles(CLI::App& app, TilesArguments& args);

// Flies once with each way, writes the table if there is a folder for it, and returns it.
Result<nlohmann::ordered_json> tiles(const TilesArguments& args);

}  // namespace foreland::apps
