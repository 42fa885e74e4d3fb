#include "apps/bench_calibrate.h"

#include "apps/bench_flight.h"
#include "apps/options.h"
#include "bench/tables.h"
#include "bench/world/calibrate.h"

namespace foreland::apps {

CLI::App* addCalibrate(CLI::App& app, CalibrateArguments& args) {
  CLI::App* sub = app.add_subcommand("calibrate", "what a server's work costs on this machine, for experiments");
  sub->add_option("scene", args.scene, "scene file (foreland build)")->required();
  sub->add_option("-o,--output", args.output, "the calibration, a JSON file")->required();
  sub->add_option("--seconds", args.seconds, "of each flight")
      ->check(CLI::Range(1.0, 600.0) & isFinite())
      ->capture_default_str();
  sub->add_flag_callback(
      "--json", [&args] { args.format = bench::ReportFormat::kJson; }, "print JSON");
  return sub;
}

Result<nlohmann::ordered_json> calibrate(const CalibrateArguments& args) {
  const auto scene = terrain::Scene::open(args.scene);
  if (!scene) return scene.error();
  const auto world = server::openWorld(*scene, server::Occlusion::kOn);
  if (!world) return world.error();
  const bench::Calibration found = bench::calibrate(bench::timeSteps(*world, args.seconds));
  const std::filesystem::path folder = args.output.has_parent_path() ? args.output.parent_path() : ".";
  if (Status s = bench::writeFile(folder, args.output.filename().string(), found.prices.toJson()); !s.ok())
    return s.error();
  return bench::toJson(found);
}

}  // namespace foreland::apps
