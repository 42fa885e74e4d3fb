// An experiment as a TOML file: which one, with which seeds, and its runs, whose keys are the options of
// `foreland bench latency`, `load` or `tiles`. lab/README.md says what stands in it. Main thread.
#pragma once

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "base/result.h"

namespace foreland::apps {

struct ExperimentFile {
  struct Run {
    std::string name;
    int line = 0;                      // in the file, for messages
    std::vector<std::string> options;  // as on the command line, scene included
  };
  std::string experiment;  // latency, load or tiles
  std::vector<uint64_t> seeds{1};
  std::vector<std::string> metrics{};  // columns of the table of all runs; empty: all
  std::vector<Run> runs;
};

// Reads the file. Errors name the file, the line and the key that is unknown, missing, twice there or of the wrong
// type.
Result<ExperimentFile> readExperiment(const std::filesystem::path& path);

}  // namespace foreland::apps
