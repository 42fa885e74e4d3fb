#include "apps/bench_tiles.h"

#include "bench/oracle/scene_truth.h"
#include "bench/report.h"
#include "bench/tables.h"
#include "bench/tiles/tile_rival.h"

namespace foreland::apps {

namespace {

Result<bench::RivalFlight> flightOf(const TilesArguments& args, const PlannedFlight& planned) {
  auto objects = server::objectsOf(planned.scene);
  if (!objects) return objects.error();
  if (!planned.scene->objectSection().empty())
    return Error{ErrorCode::kUnsupported, "the scene has objects, which tiles of heights have not; use one without"};
  const auto prices = pricesOf(args.experiment);
  if (!prices) return prices.error();
  const auto link = bench::linkNamed(args.link);
  if (!link) return link.error();
  bench::RivalFlight flight{.world = std::make_shared<server::World>(planned.scene, std::move(*objects)),
                            .path = planned.path,
                            .seconds = planned.options.seconds,
                            .tau_px = planned.options.tau_px,
                            .lens = {1.0471975511965976, args.width_px, args.height_px},
                            .links = link->links(),
                            .prices = *prices,
                            .seed = args.experiment.seed};
  flight.path.start = Time{} + bench::kTilesStanding;
  if (args.camera == Camera::kJumps) flight.path = bench::withJump(flight.path, flight.seconds);
  return flight;
}

// Ours; tiles as CesiumJS asks for them by default; tiles with our error, in either codec.
Result<std::vector<bench::RivalFigures>> compare(const bench::RivalFlight& flight,
                                                 const std::shared_ptr<const terrain::Scene>& scene) {
  bench::Oracle oracle(bench::truthOf(scene));
  bench::TileTree tree(scene);
  std::vector<bench::RivalFigures> all{bench::flyOurs(flight, oracle)};
  const auto equal_px = bench::errorForRms(flight, all[0].rms_px, tree, oracle);
  if (!equal_px) return equal_px.error();
  bench::TileOptions options{.lens = flight.lens, .links = flight.links, .seed = flight.seed};
  const auto fly = [&](double most_error_px, bench::TileCodec codec) -> Status {
    options.most_error_px = most_error_px;
    options.codec = codec;
    auto figures = bench::flyTiles(flight, options, tree, oracle);
    if (!figures) return figures.error();
    all.push_back(std::move(*figures));
    return {};
  };
  if (Status s = fly(2, bench::TileCodec::kQuantizedMesh); !s.ok()) return s.error();
  if (Status s = fly(*equal_px, bench::TileCodec::kQuantizedMesh); !s.ok()) return s.error();
  if (Status s = fly(*equal_px, bench::TileCodec::kDraco); !s.ok()) return s.error();
  return all;
}

}  // namespace

CLI::App* addTiles(CLI::App& app, TilesArguments& args) {
  CLI::App* sub = app.add_subcommand("tiles", "one flight, with our stream and pulling tiles as CesiumJS does");
  args.flight.flight.seconds = 10;
  addFlightOptions(*sub, args.flight);
  addScreenOptions(*sub, args.width_px, args.height_px);
  sub->add_option("--link", args.link, "fixed, wifi, lte, starlink, geo")->capture_default_str();
  sub->add_flag_callback(
      "--jump", [&args] { args.camera = Camera::kJumps; }, "let the camera jump in the middle of the flight");
  addExperimentOptions(*sub, args.experiment);
  return sub;
}

Result<nlohmann::ordered_json> tiles(const TilesArguments& args) {
  const auto planned = planFlight(args.flight);
  if (!planned) return planned.error();
  const auto flight = flightOf(args, *planned);
  if (!flight) return flight.error();
  const auto figures = compare(*flight, planned->scene);
  if (!figures) return figures.error();
  nlohmann::ordered_json report{{"experiment", "tiles"}};
  report.update(aboutExperiment(args.experiment, flight->prices));
  report["scene"] = std::filesystem::path(args.flight.scene).filename().string();
  report.update(flightReport(args.flight, *planned));
  report["link"] = args.link;
  report["jump"] = args.camera == Camera::kJumps;
  if (Status s = bench::reportWays(*figures, args.experiment.out, report); !s.ok()) return s.error();
  return report;
}

}  // namespace foreland::apps
