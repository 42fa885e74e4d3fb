// `foreland bench surfaces`: its options and what it runs (lab/surfaces).
#pragma once

#include <CLI/CLI.hpp>
#include <cstdint>
#include <string>
#include <vector>

#include "apps/report/report.h"
#include "base/result.h"
#include "lab/surfaces/measure.h"

namespace foreland::apps {

struct SurfaceArguments {
  lab::SurfaceSession session;
  std::string shape = "both";
  std::vector<std::string> models;  // in place of the shapes, if there are any
  uint32_t halvings = 5, base_triangles = 200;
  apps::ReportFormat format = apps::ReportFormat::kText;
};

// Registers the subcommand; `args` must outlive the parsing.
CLI::App* addSurfaces(CLI::App& app, SurfaceArguments& args);

// The report. An Error if a surface cannot be made.
Result<nlohmann::ordered_json> surfaces(const SurfaceArguments& args);

}  // namespace foreland::apps
