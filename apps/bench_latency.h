// `foreland bench latency`: its options, and the experiment that they ask for.
#pragma once

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>
#include <string>

#include "apps/bench_experiment.h"
#include "apps/bench_flight.h"
#include "bench/latency/grid.h"
#include "bench/latency/judged_frames.h"

namespace foreland::apps {

struct LatencyArguments {
  FlightArguments flight;
  ExperimentArguments experiment;
  bench::GridRequest grid;
  std::filesystem::path trace_up, trace_down;
  double judge_hz = bench::JudgedFrames::kMost_hz;
  uint32_t width_px = 1920, height_px = 1080;
};

CLI::App* addLatency(CLI::App& app, LatencyArguments& args);

// Whether the grid, the prices and the recorded links are usable.
Status checkArguments(const LatencyArguments& args);

// Flies the grid, writes its files if there is a folder for them, and returns the summary.
Result<nlohmann::ordered_json> latency(const LatencyArguments& args);

}  // namespace foreland::apps
