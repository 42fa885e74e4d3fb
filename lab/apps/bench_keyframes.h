// `foreland bench keyframes`: the work of one viewer's keyframes on the server (lab/load/server_flight.h).
#pragma once

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>
#include <string>

#include "lab/apps/bench_flight.h"
#include "lab/load/server_flight.h"

namespace foreland::apps {

struct KeyframesArguments {
  FlightArguments flight;
  std::string predictor = "velocity";
  lab::ServerFlightOptions options;
};

CLI::App* addKeyframes(CLI::App& app, KeyframesArguments& args);

Result<nlohmann::ordered_json> keyframes(const KeyframesArguments& args);

}  // namespace foreland::apps
