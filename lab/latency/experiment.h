// `foreland bench latency`: all flights of a grid, on several threads, and what they leave behind. Equal arguments give
// equal files, whatever the number of threads.
#pragma once

#include <functional>
#include <nlohmann/json.hpp>

#include "lab/cells.h"
#include "lab/latency/figures.h"

namespace foreland::lab {

inline constexpr CellNames kLatencyNames{"cell", "cells"};

// A flight's row, and its rows of frames.csv (each judged frame) and keyframes.csv.
CellTables tablesOf(const CellFlight& flight, double seconds);

// The cells, those that are kept without flying them; `asked` says what they share. Those in which programs of the
// user's take part are neither kept nor found, since such a program may have changed; if one fails, its Error.
Result<std::vector<CellTables>> flyGrid(const LatencyFlight& flight, const std::vector<LatencyCell>& cells,
                                        const nlohmann::ordered_json& asked, const KeptCells& kept, unsigned threads,
                                        const std::function<void(size_t done)>& on_progress);

// An Error that names the first flight in which a frame's total error is above the sum of its terms (P, section 4).
Status checkBound(const std::vector<CellTables>& tables);

}  // namespace foreland::lab
