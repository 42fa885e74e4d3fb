// `foreland bench load`: runs of several policies, phases and starts on several threads, and what they leave behind.
// Equal arguments give equal files, whatever the number of threads.
#pragma once

#include <functional>
#include <nlohmann/json.hpp>

#include "lab/cells.h"
#include "lab/load/load_run.h"

namespace foreland::lab {

struct LoadRequest {
  LoadOptions base;
  std::vector<size_t> viewers{};  // one run for each number; empty: base.viewers
  // Empty: all; with several servers edf, random and early, which is how `foreland serve` runs.
  std::vector<std::string> policies{}, phases{}, starts{};
  std::vector<double> slacks_ms{LoadOptions{}.slack_ms};            // without early starts they are without effect
  std::vector<std::string> queues{};                                // empty: shared
  std::vector<std::string> balances{}, fails{}, drains{}, joins{};  // of several servers; the last three SERVER@SECONDS
  std::string balance_command{}, order_command{};                   // one more of the balances, and of the policies
};

// The runs that are asked for. Errors name what is unknown.
Result<std::vector<LoadOptions>> runsOf(const LoadRequest& request);

inline constexpr CellNames kLoadNames{"run", "runs"};

// What tells this run from others of the experiment, and with it its figures.
nlohmann::ordered_json askedBy(const LoadOptions& options);
nlohmann::ordered_json rowOf(const LoadRun& run);
// A run's row, and its rows of utilisation.csv (share used, bin by bin) and lateness.csv (the distribution); of several
// servers also of servers.csv (use and viewers of each over time), in_time.csv (keyframes that were there in time, of
// those asked for, over time) and moves.csv (viewers who connected again).
CellTables tablesOf(const LoadRun& run);

// The runs, those that are kept without running them; `asked` says what they share. Runs in which programs of the
// user's take part are neither kept nor found, since such a program may have changed; if one fails, its Error.
Result<std::vector<CellTables>> runAll(const std::shared_ptr<const server::World>& world,
                                       const std::vector<LoadOptions>& runs, const nlohmann::ordered_json& asked,
                                       const KeptCells& kept, unsigned threads,
                                       const std::function<void(size_t done)>& on_progress);

// For each way of serving that has runs of several numbers of viewers: `most_viewers`, the largest of these up to which
// fewer than a thousandth of the deadlines are missed (0: even the fewest miss more), and `fewest_missing`, the least
// number that misses more (0: none does). A row for each way.
std::vector<nlohmann::ordered_json> capacitiesOf(const std::vector<CellTables>& cells);
// The rows as a table.
std::string capacityCsv(const std::vector<nlohmann::ordered_json>& capacities);

// The largest number of viewers that miss fewer than a thousandth of their deadlines, to a twentieth of it: doubled
// until too many do, then halved in between. 0 if not even one viewer is served so.
Result<size_t> maxViewers(const std::shared_ptr<const server::World>& world, LoadOptions options);

}  // namespace foreland::lab
