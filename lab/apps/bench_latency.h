// `foreland bench latency`: its options, and the experiment that they ask for.
#pragma once

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>
#include <string>

#include "lab/apps/bench_experiment.h"
#include "lab/apps/bench_flight.h"
#include "lab/latency/grid.h"
#include "lab/latency/judged_frames.h"

namespace foreland::apps {

struct LatencyArguments {
  FlightArguments flight;
  ExperimentArguments experiment;
  lab::GridRequest grid;
  std::filesystem::path trace_up, trace_down;
  double judge_hz = lab::JudgedFrames::kMax_hz;
  uint32_t width_px = 1920, height_px = 1080;
};

CLI::App* addLatency(CLI::App& app, LatencyArguments& args);

// Whether the grid, the prices and the recorded links are usable.
Status checkArguments(const LatencyArguments& args);

// Flies the grid, writes its files if there is a folder for them, and returns the summary.
Result<nlohmann::ordered_json> latency(const LatencyArguments& args);

}  // namespace foreland::apps
