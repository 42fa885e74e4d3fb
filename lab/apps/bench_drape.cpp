#include "lab/apps/bench_drape.h"
#include "apps/options/options.h"

#include <algorithm>
#include <limits>

#include "apps/report/report.h"
#include "lab/drape/drape_flight.h"
#include "lab/tables.h"

namespace foreland::apps {

namespace {

Result<uint8_t> layerOf(const terrain::Scene& scene, const std::string& name) {
  const auto content = name == "relief" ? proto::TileContent::kRelief : proto::TileContent::kImagery;
  const auto layers = scene.tiles().layers();
  for (size_t i = 0; i < layers.size(); ++i)
    if (layers[i].content == content) return static_cast<uint8_t>(i);
  return Error{ErrorCode::kUnsupported, "the scene has no " + name + "; build it again, with --imagery for pictures"};
}

Result<lab::DrapeFlight> flightOf(const DrapeArguments& args, const PlannedFlight& planned) {
  const auto layer = layerOf(*planned.scene, args.layer);
  if (!layer) return layer.error();
  const auto prices = pricesOf(args.experiment);
  if (!prices) return prices.error();
  sim::LinkPair links = sim::fixedLink(Duration::seconds(1e-3 * args.round_trip_ms));
  links.down.bytes_per_second = 1e6 / 8 * args.mbit_s;
  const auto world = server::openWorld(planned.scene);
  if (!world) return world.error();
  lab::DrapeFlight flight{
      .scene = planned.scene,
      .world = *world,
      .layer = *layer,
      .path = planned.path,
      .seconds = planned.options.seconds,
      .lens = {1.0471975511965976, args.width_px, args.height_px},
      .predictor = args.predictor == "path" ? proto::Predictor::kKnownPath : proto::Predictor::kConstantVelocity,
      .tau_px = planned.options.tau_px,
      .links = links,
      .prices = *prices,
      .seed = args.experiment.seed};
  flight.path.start = Time{} + lab::kDrapeStanding;
  return flight;
}

}  // namespace

CLI::App* addDrape(CLI::App& app, DrapeArguments& args) {
  CLI::App* sub = app.add_subcommand("drape", "one flight over tiles of relief or imagery, streamed and pulled");
  args.flight.flight.seconds = 60;
  addFlightOptions(*sub, args.flight);
  addScreenOptions(*sub, args.width_px, args.height_px);
  sub->add_option("--layer", args.layer, "which tiles the viewer is sent")
      ->check(oneOf({"relief", "imagery"}))
      ->capture_default_str();
  sub->add_option("--predictor", args.predictor, "path: known; velocity: extrapolated")
      ->check(oneOf({"path", "velocity"}))
      ->capture_default_str();
  sub->add_option("--mbit", args.mbit_s, "of the link down, megabits a second")
      ->type_name(number("MBIT"))
      ->check(within(0.01, 10'000.0))
      ->capture_default_str();
  sub->add_option("--round-trip", args.round_trip_ms, "of the link, milliseconds")
      ->type_name(number("MS"))
      ->check(within(0.0, 2000.0))
      ->capture_default_str();
  sub->add_option("--judge-every", args.judged_every_s, "seconds between the frames that are judged")
      ->type_name(number("S"))
      ->check(within(0.1, 60.0))
      ->capture_default_str();
  addExperimentOptions(*sub, args.experiment);
  return sub;
}

Result<nlohmann::ordered_json> drape(const DrapeArguments& args) {
  const auto planned = planFlightOverPlane(args.flight);
  if (!planned) return planned.error();
  const auto flight = flightOf(args, *planned);
  if (!flight) return flight.error();
  auto experiment = lab::DrapeExperiment::create(*flight, args.judged_every_s);
  if (!experiment) return experiment.error();
  const auto [ours, with] = experiment->flyOurs();
  std::vector<lab::DrapeFigures> all{ours};
  for (const auto rule : {lab::TileRule::kDistance, lab::TileRule::kArea}) all.push_back(experiment->pull(rule, 2));
  all.push_back(experiment->pull(lab::TileRule::kDistance, 1.33));
  uint64_t best = std::numeric_limits<uint64_t>::max(), best_first = best;
  for (const auto rule : {lab::TileRule::kDistance, lab::TileRule::kArea}) {
    all.push_back(experiment->pullForPsnr(rule, ours.quality.psnr_db));
    best = std::min(best, all.back().bytes);
    best_first = std::min(best_first, all.back().first_view_bytes);
  }
  nlohmann::ordered_json report{{"experiment", "drape"}};
  report.update(aboutExperiment(args.experiment, flight->prices));
  report["scene"] = std::filesystem::path(args.flight.scene).filename().string();
  report.update(flightReport(args.flight, *planned));
  report["layer"] = args.layer;
  report["predictor"] = args.predictor;
  report["mbit_s"] = args.mbit_s;
  report["round_trip_ms"] = args.round_trip_ms;
  report["bytes_over_best_rival"] = double(ours.bytes) / double(std::max<uint64_t>(best, 1));
  report["first_view_over_best_rival"] = double(ours.first_view_bytes) / double(std::max<uint64_t>(best_first, 1));
  const lab::DrapeArrivals without = experiment->flyWithoutTiles();
  report["first_picture_over_without"] = with.first_picture_ms / without.first_picture_ms;
  report["lateness_p99_more_ms"] = with.lateness_p99_ms - without.lateness_p99_ms;
  report["with_tiles"] = apps::toJson(with);
  report["without_tiles"] = apps::toJson(without);
  if (Status s = lab::reportWays(all, args.experiment.out, report); !s.ok()) return s.error();
  return report;
}

}  // namespace foreland::apps
