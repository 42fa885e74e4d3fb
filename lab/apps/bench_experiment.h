// What the experiments among the benchmarks share: seed, threads, calibration, the folder for results, progress on a
// terminal, and what every result says about how it was made. Main thread.
#pragma once

#include <CLI/CLI.hpp>
#include <chrono>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

#include "base/result.h"
#include "lab/cells.h"
#include "sim/compute_cost.h"
#include "terrain/store/scene.h"

namespace foreland::apps {

struct ExperimentArguments {
  std::filesystem::path out;
  std::filesystem::path calibration;  // empty: the prices that ship
  uint64_t seed = 1;
  unsigned threads = 0;         // 0: one for each processor
  std::filesystem::path cells;  // folder in which finished cells are kept; empty: nowhere
  std::string command;          // what reports say was asked; without what does not change the result
};

void addExperimentOptions(CLI::App& app, ExperimentArguments& args);
// --threads alone.
void addThreadsOption(CLI::App& app, unsigned& threads);

// `foreland bench ...` as it was called, without --out, --threads and --json.
std::string commandText(int argc, char** argv);

Result<sim::ComputePrices> pricesOf(const ExperimentArguments& args);

// Command, seed, calibration and version.
nlohmann::ordered_json aboutExperiment(const ExperimentArguments& args, const sim::ComputePrices& prices);

// Everything in which two experiments on the same `about` and scene may differ: `about` without the command that asked,
// but with the scene's content and the protocol.
nlohmann::ordered_json askedOf(nlohmann::ordered_json about, const terrain::Scene& scene);

// Counts pieces of work on the terminal, with the time that is left; prints nothing elsewhere.
class Progress {
 public:
  explicit Progress(size_t count);
  void show(size_t done) const;
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

 private:
  size_t count_;
  bool is_shown_;
  std::chrono::steady_clock::time_point begin_ = std::chrono::steady_clock::now();
};

}  // namespace foreland::apps
