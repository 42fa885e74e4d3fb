#include "lab/apps/bench_cost.h"

#include <toml++/toml.h>
#include <array>
#include <cmath>
#include <cstdio>

#include "apps/options/options.h"
#include "lab/cost.h"
#include "lab/programs/lab_folder.h"
#include "lab/tables.h"

namespace foreland::apps {

namespace {

using Json = nlohmann::ordered_json;

struct Price {
  const char *table, *key;
  double* value;
  double least, most;
};

Result<toml::table> parsed(const std::filesystem::path& path) {
  try {
    return toml::parse_file(path.string());
  } catch (const toml::parse_error& error) {
    return Error{ErrorCode::kMalformed, path.string() + ":" + std::to_string(error.source().begin.line) + ": " +
                                            std::string(error.description())};
  }
}

Result<lab::CostPrices> readPrices(const std::filesystem::path& path) {
  const auto file = parsed(path);
  if (!file) return file.error();
  lab::CostPrices prices;
  prices.name = (*file)["name"].value_or(std::string());
  prices.currency = (*file)["currency"].value_or(std::string("?"));
  const std::array<Price, 6> all{Price{"", "visit_minutes", &prices.visit_minutes, 0.1, 1e5},
                                 Price{"server", "egress_gb", &prices.server_egress_gb, 0, 1e6},
                                 Price{"server", "processor_hour", &prices.processor_hour, 0, 1e6},
                                 Price{"server", "processor_use", &prices.processor_use, 0.01, 1},
                                 Price{"cdn", "egress_gb", &prices.cdn_egress_gb, 0, 1e6},
                                 Price{"cdn", "million_requests", &prices.cdn_million_requests, 0, 1e6}};
  for (const Price& price : all) {
    const auto node = *price.table ? (*file)[price.table][price.key] : (*file)[price.key];
    const auto value = node.value<double>();
    char text[120];
    std::snprintf(text, sizeof text, "%s%s%s must be a number from %g to %g", price.table, *price.table ? "." : "",
                  price.key, price.least, price.most);
    if (!value || !(*value >= price.least && *value <= price.most))
      return Error{ErrorCode::kInvalidArgument, path.string() + ": " + text + "; lab/prices.toml is an example"};
    *price.value = *value;
  }
  return prices;
}

std::string lineOf(const lab::ViewerHour& hour, const std::string& currency) {
  char text[240];
  std::snprintf(text, sizeof text,
                "%-14s %6.2f px asked, %.3f px RMS: %8.1f MB, %6.0f requests, %5.1f s: %.5f %s, %.2f times ours",
                hour.way.c_str(), hour.asked_px, hour.rms_px, hour.mb, hour.requests, hour.processor_s, hour.cost,
                currency.c_str(), hour.over_foreland);
  return text;
}

}  // namespace

CLI::App* addCost(CLI::App& app, CostArguments& args) {
  CLI::App* sub = app.add_subcommand("cost", "what a viewer-hour costs, beside tiles from a CDN");
  sub->add_option("FOLDER", args.folder, "of `foreland bench tiles --out`")->type_name(folder("DIR"))->required();
  sub->add_option("--prices", args.prices,
                  "of egress, processors and requests; by default lab/prices.toml, which is made to be changed")
      ->type_name(file("FILE.toml"));
  sub->add_flag_callback(
      "--json", [&args] { args.format = ReportFormat::kJson; }, "print JSON");
  return sub;
}

Result<Json> cost(const CostArguments& args) {
  const auto prices = readPrices(args.prices.empty() ? lab::labFolder() / "prices.toml" : args.prices);
  if (!prices) return prices.error();
  const auto results = lab::readJson(args.folder / "results.json");
  if (!results) return results.error();
  const auto hours = lab::viewerHours(*results, *prices);
  if (!hours) return Error{hours.error().code, (args.folder / "results.json").string() + ": " + hours.error().message};
  Json report{{"experiment", "cost"},
              {"prices", prices->name},
              {"currency", prices->currency},
              {"viewer_hours", Json::array()}};
  lab::CsvTable table;
  for (const lab::ViewerHour& hour : *hours) {
    table.add(hour);
    report["viewer_hours"].push_back(args.format == ReportFormat::kJson ? toJson(hour)
                                                                        : Json(lineOf(hour, prices->currency)));
  }
  if (Status s = lab::writeFile(args.folder, "cost.csv", table.text()); !s.ok()) return s.error();
  return report;
}

}  // namespace foreland::apps
