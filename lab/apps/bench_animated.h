// `foreland bench animated`: its options and what it runs (lab/animated).
#pragma once

#include <CLI/CLI.hpp>
#include <string>

#include "base/result.h"
#include "lab/apps/bench_flight.h"

namespace foreland::apps {

struct AnimatedArguments {
  FlightArguments flight;
  std::string scene_speed = "90d/s";
  uint32_t judge_every = 23;
};

// Registers the subcommand; `args` must outlive the parsing.
CLI::App* addAnimated(CLI::App& app, AnimatedArguments& args);

// The report. An Error if the flight cannot be flown.
Result<nlohmann::ordered_json> animated(const AnimatedArguments& args);

}  // namespace foreland::apps
