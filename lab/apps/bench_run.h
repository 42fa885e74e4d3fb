// `foreland bench run`: an experiment that is written down in a file.
#pragma once

#include <CLI/CLI.hpp>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "base/result.h"

namespace foreland::apps {

// What to do: all that is not finished, all, or nothing but checks.
enum class RunMode : uint8_t { kResume, kAgain, kCheck };

struct RunArguments {
  std::filesystem::path file, out;
  unsigned threads = 0;
  RunMode mode = RunMode::kResume;
};

CLI::App* addRun(CLI::App& app, RunArguments& args);

// Checks all runs and, if that was not all that is asked for, does them one after another, and writes a folder for each
// of them and a table of all. Cells that an earlier call has finished are taken from `out`/cells.
Result<nlohmann::ordered_json> runExperiment(const RunArguments& args);

}  // namespace foreland::apps
