// `foreland bench drape`: its options, and the comparison that they ask for.
#pragma once

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>
#include <string>

#include "lab/apps/bench_experiment.h"
#include "lab/apps/bench_flight.h"

namespace foreland::apps {

struct DrapeArguments {
  FlightArguments flight;
  ExperimentArguments experiment;
  std::string layer = "imagery", predictor = "path";
  double mbit_s = 10, round_trip_ms = 50, judged_every_s = 2;
  uint32_t width_px = 1920, height_px = 1080;
};

CLI::App* addDrape(CLI::App& app, DrapeArguments& args);

// Flies once with our stream and with each rival's rule, by default and at our quality, and returns the table.
Result<nlohmann::ordered_json> drape(const DrapeArguments& args);

}  // namespace foreland::apps
