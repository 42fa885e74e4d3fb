// `foreland bench load`: its options, and the experiment that they ask for.
#pragma once

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>
#include <string>

#include "apps/report/report.h"
#include "lab/apps/bench_experiment.h"
#include "lab/apps/bench_link.h"
#include "lab/load/experiment.h"

namespace foreland::apps {

enum class Search : uint8_t { kNone, kMaxViewers };
enum class InTime : uint8_t { kVirtual, kBoth };  // virtual time alone, or real time as well

struct LoadArguments {
  std::string scene, mix = "mixed", predictor = "velocity", occlusion = "off";
  LinkArguments link;
  ExperimentArguments experiment;
  lab::LoadRequest request;
  Search search = Search::kNone;
  InTime in_time = InTime::kVirtual;
  apps::ReportFormat format = apps::ReportFormat::kText;
};

CLI::App* addLoad(CLI::App& app, LoadArguments& args);

// Whether the mix, the link, the runs and the prices are usable.
Status checkArguments(const LoadArguments& args);

// Runs what is asked for, writes its files if there is a folder for them, and returns the summary.
Result<nlohmann::ordered_json> load(const LoadArguments& args);

}  // namespace foreland::apps
