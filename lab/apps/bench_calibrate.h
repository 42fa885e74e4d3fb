// `foreland bench calibrate`: measures what a server's work costs on this machine.
#pragma once

#include <CLI/CLI.hpp>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

#include "apps/report/report.h"
#include "base/result.h"

namespace foreland::apps {

struct CalibrateArguments {
  std::string scene;
  std::filesystem::path output, steps;
  double seconds = 10;
  apps::ReportFormat format = apps::ReportFormat::kText;
};

CLI::App* addCalibrate(CLI::App& app, CalibrateArguments& args);
Result<nlohmann::ordered_json> calibrate(const CalibrateArguments& args);

}  // namespace foreland::apps
