#include "apps/bench_tiles.h"

#include "bench/oracle/scene_truth.h"
#include "bench/report.h"
#include "bench/tables.h"
#include "bench/tiles/tile_rival.h"

namespace foreland::apps {

namespace {

Result<bench::RivalFlight> flightOf(const TilesArguments& args, const PlannedFlight& planned) {
  if (!planned.scene->objectSection().empty())
    return Error{ErrorCode::kUnsupported, "the scene has objects, which tiles of heights have not; use one without"};
  const auto prices = pricesOf(args.experiment);
  if (!prices) return prices.error();
  const auto links = linksOf(args.link);
  if (!links) return links.error();
  const auto world = server::openWorld(planned.scene);
  if (!world) return world.error();
  bench::RivalFlight flight{.world = *world,
                            .path = planned.path,
                            .seconds = planned.options.seconds,
                            .tau_px = planned.options.tau_px,
                            .lens = {1.0471975511965976, args.width_px, args.height_px},
                            .links = *links,
                            .prices = *prices,
                            .seed = args.experiment.seed};
  flight.path.start = Time{} + bench::kTilesStanding;
  if (args.camera == Camera::kJumps) flight.path = bench::withJump(flight.path, flight.seconds);
  return flight;
}

// Ours; tiles as CesiumJS asks for them by default; tiles with our error, in either codec. What is kept is not flown
// again; `shared` says what it depends on.
Result<std::vector<bench::CellTables>> compare(const bench::RivalFlight& flight,
                                               const std::shared_ptr<const terrain::Scene>& scene,
                                               const nlohmann::ordered_json& shared, const bench::KeptCells& kept) {
  bench::Oracle oracle(bench::truthOf(scene));
  bench::TileTree tree(scene);
  const auto cell = [&](const char* way, double asked_px, const auto& fly) {
    nlohmann::ordered_json asked = shared;
    asked.update({{"way", way}, {"asked_px", asked_px}});
    return bench::keptOr(kept, asked, fly);
  };
  const auto tilesOf = [&](const char* way, double most_error_px, bench::TileCodec codec) {
    return cell(way, most_error_px, [&, most_error_px, codec]() -> Result<bench::CellTables> {
      const auto figures = bench::flyTiles(flight,
                                           {.lens = flight.lens,
                                            .most_error_px = most_error_px,
                                            .codec = codec,
                                            .links = flight.links,
                                            .seed = flight.seed},
                                           tree, oracle);
      if (!figures) return figures.error();
      return bench::tablesOf(*figures);
    });
  };
  const auto ours = cell("foreland", flight.tau_px, [&]() -> Result<bench::CellTables> {
    return bench::tablesOf(bench::flyOurs(flight, oracle));
  });
  if (!ours) return ours.error();
  const auto equal = cell("equal", flight.tau_px, [&]() -> Result<bench::CellTables> {
    const auto px = bench::errorForRms(flight, ours->row["rms_px"].get<double>(), tree, oracle);
    if (!px) return px.error();
    return bench::CellTables{.row = {{"equal_px", *px}}};
  });
  if (!equal) return equal.error();
  const double equal_px = equal->row["equal_px"].get<double>();
  std::vector<bench::CellTables> all{*ours};
  for (const auto& tables : {tilesOf("quantized-mesh", 2, bench::TileCodec::kQuantizedMesh),
                             tilesOf("quantized-mesh", equal_px, bench::TileCodec::kQuantizedMesh),
                             tilesOf("draco", equal_px, bench::TileCodec::kDraco)}) {
    if (!tables) return tables.error();
    all.push_back(*tables);
  }
  return all;
}

}  // namespace

CLI::App* addTiles(CLI::App& app, TilesArguments& args) {
  CLI::App* sub = app.add_subcommand("tiles", "one flight, with our stream and pulling tiles as CesiumJS does");
  args.flight.flight.seconds = 10;
  addFlightOptions(*sub, args.flight);
  addScreenOptions(*sub, args.width_px, args.height_px);
  addLinkOptions(*sub, args.link, "wifi");
  sub->add_flag_callback(
      "--jump", [&args] { args.camera = Camera::kJumps; }, "let the camera jump in the middle of the flight");
  addExperimentOptions(*sub, args.experiment);
  return sub;
}

Status checkArguments(const TilesArguments& args) {
  if (const auto links = linksOf(args.link); !links) return links.error();
  if (const auto prices = pricesOf(args.experiment); !prices) return prices.error();
  return {};
}

Result<nlohmann::ordered_json> tiles(const TilesArguments& args) {
  const auto planned = planFlight(args.flight);
  if (!planned) return planned.error();
  const auto flight = flightOf(args, *planned);
  if (!flight) return flight.error();
  nlohmann::ordered_json report{{"experiment", "tiles"}};
  report.update(aboutExperiment(args.experiment, flight->prices));
  report["scene"] = std::filesystem::path(args.flight.scene).filename().string();
  report.update(flightReport(args.flight, *planned));
  report["link"] = args.link.link;
  report["jump"] = args.camera == Camera::kJumps;
  report["viewport"] = std::to_string(args.width_px) + "x" + std::to_string(args.height_px);
  nlohmann::ordered_json shared = askedOf(report, *planned->scene);
  Fnv1a hash;
  addPath(flight->path, hash);
  addRecordings(flight->links, hash);
  shared["flight"] = hash.value();
  const auto all = compare(*flight, planned->scene, shared, bench::KeptCells(args.experiment.cells));
  if (!all) return all.error();
  if (!args.experiment.out.empty())
    if (Status s = bench::writeCells(args.experiment.out, report, bench::kTilesNames, *all); !s.ok()) return s.error();
  report[bench::kTilesNames.all] = nlohmann::ordered_json::array();
  for (const bench::CellTables& way : *all) report[bench::kTilesNames.all].push_back(way.row);
  return report;
}

}  // namespace foreland::apps
