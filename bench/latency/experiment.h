// `foreland bench latency`: all flights of a grid, on several threads, and what they leave behind. Equal arguments give
// equal files, whatever the number of threads.
#pragma once

#include <filesystem>
#include <functional>
#include <nlohmann/json.hpp>

#include "bench/latency/figures.h"

namespace foreland::bench {

struct LatencyResult {
  std::vector<CellFigures> cells;   // in the grid's order
  std::vector<CellFlight> flights;  // the same
};

// `on_progress(done)` is called on the calling thread after flights of its own.
LatencyResult flyGrid(const LatencyFlight& flight, const std::vector<LatencyCell>& cells, unsigned threads,
                      const std::function<void(size_t done)>& on_progress);

// Writes results.csv (a row for each cell), frames.csv (for each judged frame), keyframes.csv, and results.json: what
// `about` says, and the cells.
Status writeLatency(const std::filesystem::path& folder, const nlohmann::ordered_json& about,
                    const LatencyResult& result);

}  // namespace foreland::bench
