#include "lab/apps/bench_calibrate.h"

#include "apps/options/options.h"
#include "lab/apps/bench_flight.h"
#include "lab/calibrate.h"
#include "lab/tables.h"

namespace foreland::apps {

CLI::App* addCalibrate(CLI::App& app, CalibrateArguments& args) {
  CLI::App* sub = app.add_subcommand("calibrate", "what a server's work costs on this machine, for experiments");
  sub->add_option("SCENE", args.scene, "scene file (`foreland build`)")->type_name(file("SCENE.fls"))->required();
  sub->add_option("-o,--output", args.output, "the calibration")->type_name(file("FILE.json"))->required();
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
  const lab::Calibration found = lab::calibrate(lab::timeSteps(*world, args.seconds));
  const std::filesystem::path folder = args.output.has_parent_path() ? args.output.parent_path() : ".";
  if (Status s = lab::writeFile(folder, args.output.filename().string(), found.prices.toJson()); !s.ok())
    return s.error();
  return apps::toJson(found);
}

}  // namespace foreland::apps
