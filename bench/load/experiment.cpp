#include "bench/load/experiment.h"

#include <algorithm>
#include <cmath>

#include "bench/report.h"
#include "bench/tables.h"
#include "terrain/parallel.h"

namespace foreland::bench {

namespace {

constexpr double kMostMissed = 1e-3;

double rounded(double value) { return std::round(value * 1e4) / 1e4; }

bool isServed(const std::shared_ptr<const server::World>& world, const LoadOptions& options) {
  const LoadFigures figures = runLoad(world, options).figures;
  return figures.keyframes > 0 && figures.missed_share < kMostMissed;
}

std::string textOf(const nlohmann::ordered_json& value) {
  return value.is_string() ? value.get<std::string>() : value.is_number_float() ? numberText(value) : value.dump();
}

std::string utilisationCsv(const std::vector<LoadRun>& runs) {
  CsvTable table;
  for (size_t i = 0; i < runs.size(); ++i)
    for (size_t bin = 0; bin < runs[i].used.size(); ++bin) {
      table.begin();
      table.cell("run", std::to_string(i));
      table.cell("time_s", rounded(static_cast<double>(bin) * kUtilisationBin.toSeconds()));
      table.cell("used", rounded(runs[i].used[bin]));
      table.end();
    }
  return table.text();
}

std::string latenessCsv(const std::vector<LoadRun>& runs) {
  constexpr size_t kSteps = 200;
  CsvTable table;
  for (size_t i = 0; i < runs.size(); ++i)
    for (size_t step = 0; step <= kSteps && !runs[i].lateness_ms.empty(); ++step) {
      table.begin();
      table.cell("run", std::to_string(i));
      table.cell("lateness_ms", rounded(runs[i].lateness_ms[step * (runs[i].lateness_ms.size() - 1) / kSteps]));
      table.cell("share", static_cast<double>(step) / kSteps);
      table.end();
    }
  return table.text();
}

}  // namespace

Result<std::vector<LoadOptions>> runsOf(const LoadRequest& request) {
  const auto orAll = [](const std::vector<std::string>& asked, std::vector<std::string> all) {
    return asked.empty() ? all : asked;
  };
  std::vector<LoadOptions> runs;
  for (const std::string& policy_name : orAll(request.policies, {"fifo", "edf", "least-laxity", "fair"}))
    for (const std::string& phases_name : orAll(request.phases, {"synchronised", "random", "staggered"}))
      for (const std::string& start_name : orAll(request.starts, {"late", "early"})) {
        const auto policy = policyNamed(policy_name);
        if (!policy) return policy.error();
        const auto phases = phasesNamed(phases_name);
        if (!phases) return phases.error();
        if (start_name != "late" && start_name != "early")
          return Error{ErrorCode::kInvalidArgument, "there is no start '" + start_name + "'; choose late or early"};
        LoadOptions options = request.base;
        options.policy = *policy;
        options.phases = *phases;
        options.start = start_name == "late" ? LoadStart::kLate : LoadStart::kEarly;
        runs.push_back(options);
      }
  return runs;
}

std::vector<LoadRun> runAll(const std::shared_ptr<const server::World>& world, const std::vector<LoadOptions>& runs,
                            unsigned threads, const std::function<void(size_t done)>& on_progress) {
  std::vector<LoadRun> results(runs.size());
  terrain::parallelFor(
      runs.size(), threads, [&](uint64_t i, unsigned) { results[i] = runLoad(world, runs[i]); },
      [&](uint64_t done) {
        on_progress(done);
        return true;
      });
  return results;
}

size_t mostViewers(const std::shared_ptr<const server::World>& world, LoadOptions options) {
  constexpr size_t kMost = 4096;
  const auto serves = [&](size_t viewers) {
    options.viewers = viewers;
    return isServed(world, options);
  };
  size_t good = 0, bad = std::max<size_t>(options.viewers, 1);
  while (bad <= kMost && serves(bad)) good = bad, bad *= 2;
  while (bad - good > std::max<size_t>(1, good / 20)) {
    const size_t middle = good + (bad - good) / 2;
    (serves(middle) ? good : bad) = middle;
  }
  return good;
}

nlohmann::ordered_json rowOf(const LoadRun& run) {
  nlohmann::ordered_json row{{"policy", name(run.options.policy)},
                             {"phases", name(run.options.phases)},
                             {"start", name(run.options.start)},
                             {"viewers", run.options.viewers}};
  row.update(toJson(run.figures));
  return row;
}

Status writeLoad(const std::filesystem::path& folder, const nlohmann::ordered_json& about,
                 const std::vector<LoadRun>& runs) {
  CsvTable table;
  nlohmann::ordered_json json = about;
  json["runs"] = nlohmann::ordered_json::array();
  for (const LoadRun& run : runs) {
    const nlohmann::ordered_json row = rowOf(run);
    table.begin();
    for (const auto& [key, value] : row.items()) table.cell(key, textOf(value));
    table.end();
    json["runs"].push_back(row);
  }
  if (Status s = writeFile(folder, "results.csv", table.text()); !s.ok()) return s;
  if (Status s = writeFile(folder, "utilisation.csv", utilisationCsv(runs)); !s.ok()) return s;
  if (Status s = writeFile(folder, "lateness.csv", latenessCsv(runs)); !s.ok()) return s;
  return writeFile(folder, "results.json", json.dump(1) + "\n");
}

}  // namespace foreland::bench
