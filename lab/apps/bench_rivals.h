// `foreland bench rivals`: its options, and the flights in a browser that they ask for.
#pragma once

#include <CLI/CLI.hpp>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "lab/apps/bench_flight.h"
#include "lab/apps/bench_link.h"
#include "lab/rivals/flight_plan.h"

namespace foreland::apps {

struct RivalsArguments {
  FlightArguments flight;
  LinkArguments link;
  double poses_per_s = 10;
  std::vector<std::string> rivals{"cesium", "maplibre", "3d-tiles"};
  std::vector<double> qualities;  // empty: those of each rival's own list
  std::string protocol = "http2", predictor = "velocity";
  std::filesystem::path sources = lab::rivalsSources();
};

CLI::App* addRivals(CLI::App& app, RivalsArguments& args);

// Flies us and each rival in a browser, in real time, and returns what measure.mjs reports. An Error names what is not
// installed, and how to install it.
Result<nlohmann::ordered_json> rivals(const RivalsArguments& args);

}  // namespace foreland::apps
