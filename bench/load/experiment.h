// `foreland bench load`: runs of several policies, phases and starts on several threads, and what they leave behind.
// Equal arguments give equal files, whatever the number of threads.
#pragma once

#include <filesystem>
#include <functional>
#include <nlohmann/json.hpp>

#include "bench/load/load_run.h"

namespace foreland::bench {

struct LoadRequest {
  LoadOptions base;
  std::vector<std::string> policies{}, phases{}, starts{};  // empty: all
};

// The runs that are asked for. Errors name what is unknown.
Result<std::vector<LoadOptions>> runsOf(const LoadRequest& request);

std::vector<LoadRun> runAll(const std::shared_ptr<const server::World>& world, const std::vector<LoadOptions>& runs,
                            unsigned threads, const std::function<void(size_t done)>& on_progress);

// The largest number of viewers that miss fewer than a thousandth of their deadlines, to a twentieth of it: doubled
// until too many do, then halved in between. 0 if not even one viewer is served so.
size_t mostViewers(const std::shared_ptr<const server::World>& world, LoadOptions options);

// A run as a row: what was asked, and its figures.
nlohmann::ordered_json rowOf(const LoadRun& run);

// Writes results.csv, results.json, utilisation.csv (time and share used, bin by bin) and lateness.csv (the
// distribution, in two hundred steps).
Status writeLoad(const std::filesystem::path& folder, const nlohmann::ordered_json& about,
                 const std::vector<LoadRun>& runs);

}  // namespace foreland::bench
