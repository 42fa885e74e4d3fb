#include "lab/load/experiment.h"

#include <algorithm>
#include <array>
#include <iterator>
#include <map>

#include "apps/report/report.h"
#include "lab/tables.h"

namespace foreland::lab {

namespace {

constexpr double kMaxMissed = 1e-3;

bool isServed(uint64_t keyframes, double missed_share) { return keyframes > 0 && missed_share < kMaxMissed; }

bool hasProgram(const LoadOptions& options) {
  return !(options.order_command.empty() && options.cluster.balance_command.empty() &&
           options.predictor_command.empty() && options.link_command.empty());
}

// How the row's viewers were served, however many they were.
nlohmann::ordered_json wayOf(const nlohmann::ordered_json& row) {
  nlohmann::ordered_json way;
  for (const char* key : {"policy", "phases", "start", "slack_ms", "queues", "balance"})
    if (row.contains(key)) way[key] = row[key];
  return way;
}

std::string utilisationCsv(const LoadRun& run) {
  CsvTable table;
  for (size_t bin = 0; bin < run.used.size(); ++bin) {
    table.begin();
    table.cell("time_s", rounded(static_cast<double>(bin) * kUtilisationBin.toSeconds()));
    table.cell("used", rounded(run.used[bin]));
    table.end();
  }
  return table.text();
}

// The distribution, in two hundred steps.
std::string latenessCsv(const LoadRun& run) {
  constexpr size_t kSteps = 200;
  CsvTable table;
  for (size_t step = 0; step <= kSteps && !run.lateness_ms.empty(); ++step) {
    table.begin();
    table.cell("lateness_ms", rounded(run.lateness_ms[step * (run.lateness_ms.size() - 1) / kSteps]));
    table.cell("share", static_cast<double>(step) / kSteps);
    table.end();
  }
  return table.text();
}

std::string serversCsv(const ClusterRun& run) {
  CsvTable table;
  for (const ServerLook& look : run.looks) {
    table.begin();
    table.cell("time_s", rounded(look.time_s));
    table.cell("server", std::to_string(look.server + 1));
    table.cell("used", rounded(look.used));
    table.cell("viewers", std::to_string(look.viewers));
    table.end();
  }
  return table.text();
}

std::string inTimeCsv(const ClusterRun& run, double seconds) {
  const double bin_s = kClusterBin.toSeconds(), asked = static_cast<double>(run.figures.asked) * bin_s / seconds;
  CsvTable table;
  for (size_t bin = 0; bin < run.in_time.size(); ++bin) {
    table.begin();
    table.cell("time_s", rounded(bin_s * static_cast<double>(bin)));
    table.cell("in_time", rounded(static_cast<double>(run.in_time[bin]) / asked));
    table.end();
  }
  return table.text();
}

std::string movesCsv(const ClusterRun& run) {
  constexpr std::array<const char*, 3> kCauses{"balanced", "drained", "lost"};
  CsvTable table;
  for (const ViewerMove& move : run.moves) {
    table.begin();
    table.cell("time_s", rounded(move.at_s));
    table.cell("cause", kCauses[static_cast<size_t>(move.cause)]);
    table.cell("resumed", move.is_resumed ? "1" : "0");
    table.cell("gap_ms", rounded(move.gap_ms));
    table.cell("up_bytes", std::to_string(move.up));
    table.cell("down_bytes", std::to_string(move.down));
    table.end();
  }
  return table.text();
}

// The servers, with everything but how they are balanced.
Result<ClusterOptions> clusterOf(const LoadRequest& request) {
  ClusterOptions cluster = request.base.cluster;
  const auto add = [&](const std::vector<std::string>& texts, ServerEvent::What what) -> Status {
    for (const std::string& text : texts) {
      const auto event = parseServerEvent(what, text);
      if (!event) return event.error();
      cluster.events.push_back(*event);
    }
    return {};
  };
  if (Status s = add(request.fails, ServerEvent::What::kFail); !s.ok()) return s.error();
  if (Status s = add(request.drains, ServerEvent::What::kDrain); !s.ok()) return s.error();
  if (Status s = add(request.joins, ServerEvent::What::kJoin); !s.ok()) return s.error();
  if (cluster.servers < 2 && !(cluster.events.empty() && request.balances.empty() && request.balance_command.empty()))
    return Error{ErrorCode::kInvalidArgument,
                 "one server can neither fail nor be balanced; ask for several with --servers"};
  if (Status s = checkCluster(cluster, request.base.seconds); !s.ok()) return s.error();
  return cluster;
}

Status addBalances(const LoadRequest& request, const LoadOptions& options, std::vector<LoadOptions>& runs) {
  if (options.cluster.servers < 2) runs.push_back(options);
  for (const std::string& balance_name : request.balances.empty() ? balanceNames() : request.balances) {
    const auto balance = balanceNamed(balance_name);
    if (!balance) return balance.error();
    if (options.cluster.servers < 2) break;
    runs.push_back(options);
    runs.back().cluster.balance = *balance;
  }
  if (request.balance_command.empty()) return {};
  runs.push_back(options);
  runs.back().cluster.balance_command = request.balance_command;
  return {};
}

Status addQueues(const LoadRequest& request, LoadOptions options, std::vector<LoadOptions>& runs) {
  const std::vector<size_t> numbers =
      request.viewers.empty() ? std::vector<size_t>{request.base.viewers} : request.viewers;
  for (const std::string& queues_name : request.queues.empty() ? std::vector<std::string>{"shared"} : request.queues) {
    const auto queues = queuesNamed(queues_name);
    if (!queues) return queues.error();
    options.queues = *queues;
    for (const double slack_ms : request.slacks_ms)
      for (const size_t viewers : numbers) {
        options.slack_ms = slack_ms;
        options.viewers = viewers;
        if (Status s = addBalances(request, options, runs); !s.ok()) return s;
      }
  }
  return {};
}

// A policy of ours or, under `command`, of the user's.
struct Order {
  LoadPolicy policy = LoadPolicy::kEdf;
  std::string command{};
};

Result<std::vector<Order>> ordersOf(const std::vector<std::string>& policies, const std::string& command) {
  std::vector<Order> orders;
  for (const std::string& policy_name : policies) {
    const auto policy = policyNamed(policy_name);
    if (!policy) return policy.error();
    orders.push_back({*policy});
  }
  if (!command.empty()) orders.push_back({LoadPolicy::kEdf, command});
  return orders;
}

}  // namespace

Result<std::vector<LoadOptions>> runsOf(const LoadRequest& request) {
  const auto cluster = clusterOf(request);
  if (!cluster) return cluster.error();
  const auto orAll = [&](const std::vector<std::string>& asked, const char* usual, std::vector<std::string> all) {
    return !asked.empty() ? asked : cluster->servers > 1 ? std::vector<std::string>{usual} : all;
  };
  const auto orders =
      ordersOf(orAll(request.policies, "edf", {"fifo", "edf", "least-laxity", "fair"}), request.order_command);
  if (!orders) return orders.error();
  std::vector<LoadOptions> runs;
  for (const Order& order : *orders)
    for (const std::string& phases_name : orAll(request.phases, "random", {"synchronised", "random", "staggered"}))
      for (const std::string& start_name : orAll(request.starts, "early", {"late", "early"})) {
        const auto phases = phasesNamed(phases_name);
        if (!phases) return phases.error();
        if (start_name != "late" && start_name != "early")
          return Error{ErrorCode::kInvalidArgument, "there is no start '" + start_name + "'; choose late or early"};
        LoadOptions options = request.base;
        options.cluster = *cluster;
        options.policy = order.policy;
        options.order_command = order.command;
        options.phases = *phases;
        options.start = start_name == "late" ? LoadStart::kLate : LoadStart::kEarly;
        if (Status s = addQueues(request, options, runs); !s.ok()) return s.error();
      }
  return runs;
}

CellTables tablesOf(const LoadRun& run) {
  CellTables tables{.row = rowOf(run)};
  tables.rows = {{"utilisation.csv", utilisationCsv(run)}, {"lateness.csv", latenessCsv(run)}};
  if (!run.cluster) return tables;
  tables.rows.emplace_back("servers.csv", serversCsv(*run.cluster));
  tables.rows.emplace_back("in_time.csv", inTimeCsv(*run.cluster, run.options.seconds));
  tables.rows.emplace_back("moves.csv", movesCsv(*run.cluster));
  return tables;
}

Result<std::vector<CellTables>> runAll(const std::shared_ptr<const server::World>& world,
                                       const std::vector<LoadOptions>& runs, const nlohmann::ordered_json& asked,
                                       const KeptCells& kept, unsigned threads,
                                       const std::function<void(size_t done)>& on_progress) {
  const auto compute = [&](size_t i, unsigned) -> Result<CellTables> {
    const LoadRun run = runLoad(world, runs[i]);
    if (!run.status.ok()) return run.status.error();
    return tablesOf(run);
  };
  const auto isKeepable = [&](size_t i) { return !hasProgram(runs[i]); };
  const auto askedOf = [&](size_t i) {
    nlohmann::ordered_json all = asked;
    all.update(askedBy(runs[i]));
    return all;
  };
  return runCells({runs.size(), askedOf, compute, on_progress, isKeepable}, kept, threads);
}

std::vector<nlohmann::ordered_json> capacitiesOf(const std::vector<CellTables>& cells) {
  struct Way {
    nlohmann::ordered_json how;
    std::map<size_t, bool> served;  // by the number of viewers
  };
  std::vector<Way> ways;
  for (const CellTables& cell : cells) {
    nlohmann::ordered_json how = wayOf(cell.row);
    auto way = std::ranges::find(ways, how, &Way::how);
    if (way == ways.end()) way = ways.insert(way, {std::move(how), {}});
    way->served[cell.row["viewers"].get<size_t>()] =
        isServed(cell.row["keyframes"].get<uint64_t>(), cell.row["missed_share"].get<double>());
  }
  std::vector<nlohmann::ordered_json> capacities;
  for (const auto& [how, served] : ways) {
    if (served.size() < 2) continue;
    const auto first = std::ranges::find(served, false, [](const auto& entry) { return entry.second; });
    capacities.push_back(how);
    capacities.back()["most_viewers"] = first == served.begin() ? size_t{0} : std::prev(first)->first;
    capacities.back()["fewest_missing"] = first == served.end() ? size_t{0} : first->first;
  }
  return capacities;
}

std::string capacityCsv(const std::vector<nlohmann::ordered_json>& capacities) {
  CsvTable table;
  for (const nlohmann::ordered_json& row : capacities) table.addRow(row);
  return table.text();
}

Result<size_t> maxViewers(const std::shared_ptr<const server::World>& world, LoadOptions options) {
  constexpr size_t kMax = 4096;
  Status status;
  const auto serves = [&](size_t viewers) {
    options.viewers = viewers;
    const LoadRun run = runLoad(world, options);
    if (!run.status.ok()) status = run.status;
    return status.ok() && isServed(run.figures.keyframes, run.figures.missed_share);
  };
  size_t good = 0, bad = std::max<size_t>(options.viewers, 1);
  while (bad <= kMax && serves(bad)) good = bad, bad *= 2;
  while (bad - good > std::max<size_t>(1, good / 20)) {
    const size_t middle = good + (bad - good) / 2;
    (serves(middle) ? good : bad) = middle;
    if (!status.ok()) break;
  }
  if (!status.ok()) return status.error();
  return good;
}

nlohmann::ordered_json askedBy(const LoadOptions& options) {
  const auto called = [](const std::string& command, const char* own) { return command.empty() ? own : command; };
  nlohmann::ordered_json asked{{"policy", called(options.order_command, name(options.policy))},
                               {"phases", name(options.phases)},
                               {"start", name(options.start)},
                               {"slack_ms", options.slack_ms},
                               {"queues", name(options.queues)},
                               {"viewers", options.viewers}};
  if (options.cluster.servers > 1)
    asked["balance"] = called(options.cluster.balance_command, name(options.cluster.balance));
  return asked;
}

nlohmann::ordered_json rowOf(const LoadRun& run) {
  nlohmann::ordered_json row = askedBy(run.options);
  if (run.cluster) row.update(apps::toJson(run.cluster->figures));
  row.update(apps::toJson(run.figures));
  return row;
}

}  // namespace foreland::lab
