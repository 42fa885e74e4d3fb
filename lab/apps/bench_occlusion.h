// `foreland bench occlusion`: its options and what it runs (lab/occlusion).
#pragma once

#include <CLI/CLI.hpp>
#include <string>

#include "base/result.h"
#include "lab/apps/bench_flight.h"
#include "lab/occlusion/judge.h"

namespace foreland::apps {

struct OcclusionArguments {
  FlightArguments flight;
  std::string predictor = "path";
  lab::JudgeOptions judge;
  double street_m = 0, street_mps = 15;  // street_m above 0: along the streets between objects, instead of the tour
  uint32_t width_px = 1920, height_px = 1080;
};

// Registers the subcommand; `args` must outlive the parsing.
CLI::App* addOcclusion(CLI::App& app, OcclusionArguments& args);

// The report. An Error if the flight cannot be flown, or the scene has no occluder.
Result<nlohmann::ordered_json> occlusion(const OcclusionArguments& args);

}  // namespace foreland::apps
