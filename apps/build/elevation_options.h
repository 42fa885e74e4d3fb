// What programs that read elevation take on their command lines: foreland build, and foreland plan, whose words
// foreland block and foreland merge read again.
#pragma once

#include <CLI/CLI.hpp>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.h"
#include "terrain/dem/raster/open_options.h"
#include "terrain/elevation_source.h"

namespace foreland::apps {

struct ElevationArguments {
  std::vector<std::filesystem::path> inputs;
  std::vector<std::string> insets;
  std::vector<int> inset_priorities;
  terrain::OpenOptions open;
  std::optional<double> vertical_step_m;
};

// The options; `arguments` must live until the command line is parsed.
void describeInputs(CLI::App& app, ElevationArguments& arguments);

inline constexpr std::string_view kVerticalOfOne = "@vertical=";
// Takes what follows a file's name off it, and remembers it for that file.
std::string withoutVertical(const std::string& text, terrain::OpenOptions& open);
// After parsing: from here on inputs are names of files.
void takeVerticals(ElevationArguments& arguments);
// After parsing: gives each inset its priority.
Status takeInsets(ElevationArguments& arguments);

// All files that the options name, for reading. Some may not be there.
std::vector<std::filesystem::path> filesOf(const ElevationArguments& arguments);

// The user's, or one that fits the distance between samples; says so where it is finer than usual.
double chooseVerticalStep(const ElevationArguments& arguments, const terrain::ElevationInfo& info);
// A line on standard error.
void describeInput(const terrain::ElevationInfo& info);

}  // namespace foreland::apps
