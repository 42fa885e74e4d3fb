#include "lab/apps/bench_tiles.h"

#include "apps/report/report.h"
#include "lab/tables.h"
#include "lab/tiles/tile_rival.h"
#include "oracle/scene_truth.h"

namespace foreland::apps {

namespace {

Result<lab::RivalFlight> flightOf(const TilesArguments& args, const PlannedFlight& planned) {
  if (!planned.scene->objectSection().empty())
    return Error{ErrorCode::kUnsupported, "the scene has objects, which tiles of heights have not; use one without"};
  const auto prices = pricesOf(args.experiment);
  if (!prices) return prices.error();
  const auto links = linksOf(args.link);
  if (!links) return links.error();
  const auto world = server::openWorld(planned.scene);
  if (!world) return world.error();
  lab::RivalFlight flight{.world = *world,
                          .path = planned.path,
                          .seconds = planned.options.seconds,
                          .tau_px = planned.options.tau_px,
                          .lens = {1.0471975511965976, args.width_px, args.height_px},
                          .links = *links,
                          .prices = *prices,
                          .seed = args.experiment.seed};
  flight.path.start = Time{} + lab::kTilesStanding;
  if (args.camera == Camera::kJumps) flight.path = lab::withJump(flight.path, flight.seconds);
  return flight;
}

// Ours; tiles as CesiumJS asks for them by default; tiles with our error, in either codec. What is kept is not flown
// again; `shared` says what it depends on.
Result<std::vector<lab::CellTables>> compare(const lab::RivalFlight& flight,
                                             const std::shared_ptr<const terrain::Scene>& scene,
                                             const nlohmann::ordered_json& shared, const lab::KeptCells& kept) {
  oracle::Oracle oracle(oracle::truthOf(scene));
  lab::TileTree tree(scene);
  const auto cell = [&](const char* way, double asked_px, const auto& fly) {
    nlohmann::ordered_json asked = shared;
    asked.update({{"way", way}, {"asked_px", asked_px}});
    return lab::keptOr(kept, asked, fly);
  };
  const auto tilesOf = [&](const char* way, double max_error_px, lab::TileCodec codec) {
    return cell(way, max_error_px, [&, max_error_px, codec]() -> Result<lab::CellTables> {
      const auto figures = lab::flyTiles(flight,
                                         {.lens = flight.lens,
                                          .max_error_px = max_error_px,
                                          .codec = codec,
                                          .links = flight.links,
                                          .seed = flight.seed},
                                         tree, oracle);
      if (!figures) return figures.error();
      return lab::tablesOf(*figures);
    });
  };
  const auto ours = cell("foreland", flight.tau_px,
                         [&]() -> Result<lab::CellTables> { return lab::tablesOf(lab::flyOurs(flight, oracle)); });
  if (!ours) return ours.error();
  const auto equal = cell("equal", flight.tau_px, [&]() -> Result<lab::CellTables> {
    const auto px = lab::errorForRms(flight, ours->row["rms_px"].get<double>(), tree, oracle);
    if (!px) return px.error();
    return lab::CellTables{.row = {{"equal_px", *px}}};
  });
  if (!equal) return equal.error();
  const double equal_px = equal->row["equal_px"].get<double>();
  std::vector<lab::CellTables> all{*ours};
  for (const auto& tables : {tilesOf("quantized-mesh", 2, lab::TileCodec::kQuantizedMesh),
                             tilesOf("quantized-mesh", equal_px, lab::TileCodec::kQuantizedMesh),
                             tilesOf("draco", equal_px, lab::TileCodec::kDraco)}) {
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
  const auto planned = planFlightOverPlane(args.flight);
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
  const auto all = compare(*flight, planned->scene, shared, lab::KeptCells(args.experiment.cells));
  if (!all) return all.error();
  if (!args.experiment.out.empty())
    if (Status s = lab::writeCells(args.experiment.out, report, lab::kTilesNames, *all); !s.ok()) return s.error();
  report[lab::kTilesNames.all] = nlohmann::ordered_json::array();
  for (const lab::CellTables& way : *all) report[lab::kTilesNames.all].push_back(way.row);
  return report;
}

}  // namespace foreland::apps
