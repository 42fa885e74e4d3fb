#include "lab/apps/bench_calibrate.h"

#include "apps/options/options.h"
#include "lab/apps/bench_flight.h"
#include "lab/calibrate.h"
#include "lab/tables.h"

namespace foreland::apps {

namespace {

Status keep(const std::filesystem::path& path, const std::string& text) {
  return lab::writeFile(path.has_parent_path() ? path.parent_path() : ".", path.filename().string(), text);
}

}  // namespace

CLI::App* addCalibrate(CLI::App& app, CalibrateArguments& args) {
  CLI::App* sub = app.add_subcommand("calibrate", "what a server's work costs on this machine, for experiments");
  sub->add_option("SCENE", args.scene, "scene file (`foreland build`)")->type_name(file("SCENE.fls"))->required();
  sub->add_option("-o,--output", args.output, "the calibration")->type_name(file("FILE.json"))->required();
  sub->add_option("--steps", args.steps, "also keep what each step did and took, as a table")
      ->type_name(file("FILE.csv"));
  sub->add_option("--seconds", args.seconds, "of each flight")
      ->type_name(number("S"))
      ->check(within(1.0, 600.0))
      ->capture_default_str();
  sub->add_flag_callback(
      "--json", [&args] { args.format = apps::ReportFormat::kJson; }, "print JSON");
  return sub;
}

Result<nlohmann::ordered_json> calibrate(const CalibrateArguments& args) {
  const auto scene = terrain::Scene::open(args.scene);
  if (!scene) return scene.error();
  const auto world = server::openWorld(*scene, server::Occlusion::kOn);
  if (!world) return world.error();
  const std::vector<sim::TimedWork> steps = lab::timeSteps(*world, args.seconds);
  const lab::Calibration found = lab::calibrate(steps);
  if (Status s = keep(args.output, found.prices.toJson()); !s.ok()) return s.error();
  if (args.steps.empty()) return apps::toJson(found);
  lab::CsvTable table;
  for (const sim::TimedWork& step : steps) table.add(step);
  if (Status s = keep(args.steps, table.text()); !s.ok()) return s.error();
  return apps::toJson(found);
}

}  // namespace foreland::apps
