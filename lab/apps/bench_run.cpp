#include "lab/apps/bench_run.h"

#include <algorithm>
#include <array>
#include <set>
#include <variant>

#include "apps/options/options.h"
#include "lab/apps/bench_latency.h"
#include "lab/apps/bench_load.h"
#include "lab/apps/bench_tiles.h"
#include "lab/apps/experiment_file.h"
#include "lab/latency/experiment.h"
#include "lab/tables.h"
#include "lab/tiles/tile_rival.h"

namespace foreland::apps {

namespace {

using Json = nlohmann::ordered_json;

// Under which an experiment's report has its rows.
constexpr std::array kRowsOf{lab::kLatencyNames.all, lab::kLoadNames.all, lab::kTilesNames.all};

// A run with one seed.
struct Part {
  std::string run, folder;
  std::variant<LatencyArguments, LoadArguments, TilesArguments> arguments;

  ExperimentArguments& experiment() {
    return std::visit([](auto& a) -> ExperimentArguments& { return a.experiment; }, arguments);
  }
};

// As if the run's options stood on the command line, so that they mean the same and are refused alike.
Result<Part> partOf(const std::string& experiment, const ExperimentFile::Run& run) {
  CLI::App app;
  LatencyArguments latency_args;
  LoadArguments load_args;
  TilesArguments tiles_args;
  addLatency(app, latency_args);
  addLoad(app, load_args);
  addTiles(app, tiles_args);
  std::vector<std::string> words(run.options.rbegin(), run.options.rend());  // CLI11 takes them from the back
  words.push_back(experiment);
  try {
    app.parse(words);
  } catch (const CLI::ParseError& error) { return Error{ErrorCode::kInvalidArgument, error.what()}; }
  if (experiment == "load") return Part{run.name, run.name, load_args};
  if (experiment == "tiles") return Part{run.name, run.name, tiles_args};
  return Part{run.name, run.name, latency_args};
}

Status check(const Part& part) {
  return std::visit([](const auto& arguments) { return checkArguments(arguments); }, part.arguments);
}

Result<std::vector<Part>> partsOf(const RunArguments& args, const ExperimentFile& file) {
  std::vector<Part> parts;
  for (const ExperimentFile::Run& run : file.runs) {
    auto part = partOf(file.experiment, run);
    const Status status = part.ok() ? check(*part) : Status(part.error());
    if (!status.ok())
      return Error{status.error().code, args.file.string() + ":" + std::to_string(run.line) + ": run '" + run.name +
                                            "': " + status.error().message};
    for (const uint64_t seed : file.seeds) {
      if (file.seeds.size() > 1) part->folder = run.name + "-seed" + std::to_string(seed);
      ExperimentArguments& experiment = part->experiment();
      experiment.out = args.out / part->folder;
      experiment.cells = args.out / "cells";
      experiment.seed = seed;
      experiment.threads = args.threads;
      experiment.command = "foreland bench run " + args.file.filename().string();
      parts.push_back(*part);
    }
  }
  return parts;
}

std::set<std::string> namesOf(const Json& row) {
  std::set<std::string> names;
  for (const auto& [name, value] : row.items()) names.insert(name);
  return names;
}

// The figures that a table of this experiment may have.
std::set<std::string> metricsOf(const std::string& experiment) {
  if (experiment == "latency") return namesOf(apps::toJson(lab::CellFigures{}));
  if (experiment == "tiles") return namesOf(apps::toJson(lab::RivalFigures{}));
  lab::LoadRun run;
  run.options.cluster.servers = 2;
  run.cluster.emplace();
  return namesOf(lab::rowOf(run));
}

Status checkMetrics(const ExperimentFile& file) {
  const std::set<std::string> known = metricsOf(file.experiment);
  for (const std::string& metric : file.metrics)
    if (!known.contains(metric))
      return Error{ErrorCode::kInvalidArgument,
                   "there is no metric '" + metric + "'; results.csv of a run has a column for each that there is"};
  return {};
}

// What tells a cell from others.
std::set<std::string> keysOf(const std::string& experiment) {
  if (experiment == "latency") return namesOf(apps::toJson(lab::LatencyCell{}));
  if (experiment == "tiles") return {"way", "asked_px"};
  lab::LoadOptions options;
  options.cluster.servers = 2;
  return namesOf(lab::askedBy(options));
}

// All rows with the run and the seed they are of; a figure that a run has not is empty.
std::string tableOfAll(const std::vector<Json>& rows, const ExperimentFile& file) {
  std::set<std::string> wanted = file.metrics.empty() ? metricsOf(file.experiment) : keysOf(file.experiment);
  wanted.insert(file.metrics.begin(), file.metrics.end());
  std::vector<std::string> columns{"run", "seed"};
  for (const Json& row : rows)
    for (const auto& [name, value] : row.items())
      if (wanted.contains(name) && std::find(columns.begin(), columns.end(), name) == columns.end())
        columns.push_back(name);
  lab::CsvTable table;
  for (const Json& row : rows) {
    Json shown = Json::object();
    for (const std::string& column : columns) shown[column] = row.contains(column) ? row[column] : Json("");
    table.addRow(shown);
  }
  return table.text();
}

Result<Json> resultOf(const Part& part) {
  if (const auto* arguments = std::get_if<LatencyArguments>(&part.arguments)) return latency(*arguments);
  if (const auto* arguments = std::get_if<TilesArguments>(&part.arguments)) return tiles(*arguments);
  return load(std::get<LoadArguments>(part.arguments));
}

// The rows that the part has left in its folder.
Status addRows(const std::filesystem::path& out, const Part& part, uint64_t seed, std::vector<Json>& rows) {
  const auto results = lab::readJson(out / part.folder / "results.json");
  if (!results) return results.error();
  for (const char* key : kRowsOf)
    if (results->contains(key))
      for (const Json& row : (*results)[key]) {
        rows.push_back({{"run", part.run}, {"seed", seed}});
        rows.back().update(row);
      }
  return {};
}

}  // namespace

CLI::App* addRun(CLI::App& app, RunArguments& args) {
  CLI::App* sub = app.add_subcommand("run", "an experiment that is written down in a TOML file");
  sub->add_option("EXPERIMENT", args.file, "the file")->type_name(file("FILE.toml"))->required();
  sub->add_option("--out", args.out, "folder for the tables, and for finished cells, which are not computed again")
      ->type_name(folder("DIR"));
  addThreadsOption(*sub, args.threads);
  sub->add_flag_callback(
      "--again", [&args] { args.mode = RunMode::kAgain; }, "compute finished cells again");
  sub->add_flag_callback(
      "--check", [&args] { args.mode = RunMode::kCheck; }, "say whether the file is usable, and run nothing");
  return sub;
}

Result<Json> runExperiment(const RunArguments& args) {
  const auto file = readExperiment(args.file);
  if (!file) return file.error();
  if (Status s = checkMetrics(*file); !s.ok()) return s.error();
  auto parts = partsOf(args, *file);
  if (!parts) return parts.error();
  Json summary{{"experiment", file->experiment}, {"file", args.file.filename().string()}, {"runs", Json::array()}};
  for (const Part& part : *parts) summary["runs"].push_back(part.folder);
  if (args.mode == RunMode::kCheck) return summary;
  if (args.out.empty()) return Error{ErrorCode::kInvalidArgument, "--out is required: the folder for the tables"};
  if (args.mode == RunMode::kAgain) std::filesystem::remove_all(args.out / "cells");
  std::vector<Json> rows;
  for (Part& part : *parts) {
    const auto result = resultOf(part);
    if (!result) return Error{result.error().code, "run '" + part.run + "': " + result.error().message};
    if (Status s = addRows(args.out, part, part.experiment().seed, rows); !s.ok()) return s.error();
    for (const char* key : kRowsOf)
      if (result->contains(key)) summary[part.folder] = (*result)[key];
  }
  if (Status s = lab::writeFile(args.out, "results.csv", tableOfAll(rows, *file)); !s.ok()) return s.error();
  summary["out"] = args.out.string();
  return summary;
}

}  // namespace foreland::apps
