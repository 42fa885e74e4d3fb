// `foreland bench cost`: what a viewer-hour costs beside tiles from a CDN. Main thread.
#pragma once

#include <CLI/CLI.hpp>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "apps/report/report.h"
#include "base/result.h"

namespace foreland::apps {

struct CostArguments {
  std::filesystem::path folder, prices;
  apps::ReportFormat format = apps::ReportFormat::kText;
};

CLI::App* addCost(CLI::App& app, CostArguments& args);

// Prices the flights in the folder and writes cost.csv beside them. Errors name the file and the key that is wrong.
Result<nlohmann::ordered_json> cost(const CostArguments& args);

}  // namespace foreland::apps
