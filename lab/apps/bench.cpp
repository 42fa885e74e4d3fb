// foreland bench: what the engine costs and whether it keeps its error guarantee, beside a named rival where there is
// one. lab/README.md says how each figure is measured.
#include <CLI/CLI.hpp>
#include <cmath>
#include <iostream>
#include <optional>
#include <string>

#include "apps/options/command_line.h"
#include "apps/options/options.h"
#include "lab/apps/bench_animated.h"
#include "lab/apps/bench_calibrate.h"
#include "lab/apps/bench_cost.h"
#include "lab/apps/bench_drape.h"
#include "lab/apps/bench_flight.h"
#include "lab/apps/bench_keyframes.h"
#include "lab/apps/bench_latency.h"
#include "lab/apps/bench_load.h"
#include "lab/apps/bench_occlusion.h"
#include "lab/apps/bench_rivals.h"
#include "lab/apps/bench_run.h"
#include "lab/apps/bench_surfaces.h"
#include "lab/apps/bench_tiles.h"
#include "lab/client/measure.h"
#include "lab/client/wasm_meshes.h"
#include "lab/martini/report.h"
#include "lab/report/draw_report.h"
#include "lab/sections/errors.h"
#include "lab/sections/measure.h"
#include "lab/wire/measure.h"
#include "lab/wire/peer_report.h"
#include "lab/wire/wasm_decoder.h"
#include "server/session/world.h"

namespace foreland {
namespace {

using Report = nlohmann::ordered_json;

struct SectionArguments {
  apps::FlightArguments flight;
  uint32_t frames_per_second = 60, measure_every = lab::FrameSampling{}.measure_every;
  std::optional<double> triangles;
  bool has_errors = true;
};

struct RefineArguments {
  apps::FlightArguments flight;
  std::string martini = lab::martiniSources();
};

struct WireArguments {
  apps::FlightArguments flight;
  lab::PeerOptions peers{.quantized_mesh = lab::peerSources()};
  std::filesystem::path wasm_decoder = lab::wasmDecoderPath();
  bool has_peers = true;
};

struct ClientArguments {
  apps::FlightArguments flight;
  std::filesystem::path wasm_mesher = lab::wasmMesherPath();
};

// Under `key` of a report stands why a rival was left out.
void warnOfSkipped(const Report& report, const char* key, const char* what) {
  if (report.contains(key))
    std::cerr << "foreland bench: " << what << " skipped: " << report[key].get<std::string>() << "\n";
}

Result<Report> sections(const SectionArguments& args) {
  auto flight = apps::planFlight(args.flight);
  if (!flight) return flight.error();
  const auto hierarchy = apps::hierarchyOf(flight->scene);
  if (!hierarchy) return hierarchy.error();
  lab::FlightOptions& options = flight->options;
  const auto viewsOfFlight = [&] { return lab::keyframeViews(flight->path, options, lab::Guarantee::kEveryFrame); };
  if (args.triangles) {
    const auto tau_px = lab::tauForTriangles(*hierarchy, viewsOfFlight(), *args.triangles);
    if (!tau_px) return tau_px.error();
    options.tau_px = *tau_px;
  }
  const auto views = viewsOfFlight();
  Report report = apps::flightReport(args.flight, *flight);
  report.update(apps::toJson(lab::measureCosts(*hierarchy, views)));
  report.update(apps::toJson(lab::measureMemory(*hierarchy, views)));
  report.update(apps::toJson(lab::measureComparisons(*hierarchy, flight->path, options)));
  if (!args.has_errors) return report;
  const double frames = args.frames_per_second * options.keyframe_interval.toSeconds();
  report.update(
      apps::toJson(lab::measureErrors(*hierarchy, views, flight->path, options,
                                      {.frames_per_keyframe = static_cast<uint32_t>(std::max(1L, std::lround(frames))),
                                       .measure_every = args.measure_every})));
  return report;
}

Result<Report> refine(const RefineArguments& args) {
  const auto flight = apps::planFlightOverPlane(args.flight);
  if (!flight) return flight.error();
  const auto views = lab::keyframeViews(flight->path, flight->options, lab::Guarantee::kEveryFrame);
  Report report = apps::flightReport(args.flight, *flight);
  report.update(lab::refineReport(flight->scene, views, args.martini));
  warnOfSkipped(report, "martini_javascript_skipped", "MARTINI's JavaScript");
  return report;
}

// What a client of the flight is welcomed with.
proto::Welcome welcomeTo(const server::Hierarchy& hierarchy, const lab::FlightOptions& options) {
  proto::Welcome welcome = server::welcomeTo(hierarchy);
  welcome.tau_px = options.tau_px;
  welcome.keyframe_interval = options.keyframe_interval;
  return welcome;
}

// The flight decoded in WebAssembly; null, with the reason, where that cannot be.
Result<Report> wasmReport(const std::filesystem::path& module, const lab::FlightOptions& options,
                          const server::Hierarchy& hierarchy, const std::vector<lab::RecordedKeyframe>& flight,
                          const lab::WireCosts& costs) {
  const auto times = lab::decodeInWasm(module, welcomeTo(hierarchy, options), flight);
  Report report{{"decode_wasm_mnodes_per_s", nullptr}, {"first_decode_wasm_mnodes_per_s", nullptr}};
  if (!times && times.error().code != ErrorCode::kNotFound) return times.error();
  if (!times) {
    report["decode_wasm_skipped"] = times.error().message;
    return report;
  }
  if (times->digest != costs.digest)
    return Error{ErrorCode::kMalformed, "decoding in WebAssembly ends in another section, or in other heights"};
  const double changed = static_cast<double>(costs.nodes_added + costs.nodes_removed);
  report["decode_wasm_mnodes_per_s"] = 1e-6 * changed / times->rest_s;
  report["first_decode_wasm_mnodes_per_s"] = 1e-6 * static_cast<double>(costs.first_section_nodes) / times->first_s;
  report["node"] = times->node;
  return report;
}

Result<Report> wire(const WireArguments& args) {
  const auto flight = apps::planFlight(args.flight);
  if (!flight) return flight.error();
  const auto hierarchy = apps::hierarchyOf(flight->scene);
  if (!hierarchy) return hierarchy.error();
  const Duration interval = flight->options.keyframe_interval;
  const auto views = lab::keyframeViews(flight->path, flight->options, lab::Guarantee::kEveryFrame);
  const auto recorded = lab::recordFlight(*hierarchy, views, interval);
  const lab::WireCosts costs = lab::measureWire(*hierarchy, views, recorded, interval);
  Report report = apps::flightReport(args.flight, *flight);
  report.update(apps::toJson(costs));
  const auto wasm = wasmReport(args.wasm_decoder, flight->options, *hierarchy, recorded, costs);
  if (!wasm) return wasm.error();
  report.update(*wasm);
  warnOfSkipped(report, "decode_wasm_skipped", "WebAssembly");
  if (!args.has_peers) return report;
  if (flight->scene->grid().isCube()) {
    report["peers_skipped"] = "the scene is a globe, and their meshes are cut by squares of a plane";
    warnOfSkipped(report, "peers_skipped", "other makers' codecs");
    return report;
  }
  auto peers = lab::peersReport(*hierarchy, views, args.peers);
  if (!peers) return peers.error();
  warnOfSkipped(*peers, "quantized_mesh_skipped", "quantized-mesh");
  report["peers"] = std::move(*peers);
  return report;
}

Result<Report> clientCosts(const ClientArguments& args) {
  const auto flight = apps::planFlight(args.flight);
  if (!flight) return flight.error();
  const auto hierarchy = apps::hierarchyOf(flight->scene);
  if (!hierarchy) return hierarchy.error();
  const auto views = lab::keyframeViews(flight->path, flight->options, lab::Guarantee::kEveryFrame);
  const auto recorded = lab::recordFlight(*hierarchy, views, flight->options.keyframe_interval);
  const lab::ClientMeasurement native = lab::measureClient(*hierarchy, recorded);
  Report report = apps::flightReport(args.flight, *flight);
  report.update(apps::toJson(native.costs));
  const auto wasm =
      lab::measureInWasm(args.wasm_mesher, welcomeTo(*hierarchy, flight->options), recorded, native.keyframes);
  if (!wasm && wasm.error().code != ErrorCode::kNotFound) return wasm.error();
  if (wasm) wasm->times([&](const std::string& name, double value) { report["wasm_" + name] = value; });
  if (!wasm) report["wasm_skipped"] = wasm.error().message;
  warnOfSkipped(report, "wasm_skipped", "WebAssembly");
  return report;
}

struct ReportArguments {
  std::filesystem::path folder, sources = lab::reportSources();
};

CLI::App* addReport(CLI::App& app, ReportArguments& args) {
  CLI::App* sub = app.add_subcommand("report", "one page with the figures of an experiment");
  sub->add_option("FOLDER", args.folder, "that the experiment was told by --out")
      ->type_name(apps::folder("DIR"))
      ->required();
  sub->add_option("--sources", args.sources, "folder of draw.mjs and its node_modules")->type_name(apps::folder("DIR"));
  return sub;
}

int report(const ReportArguments& args) {
  const auto drawn = lab::drawReport(args.folder, args.sources);
  if (!drawn) {
    std::cerr << "foreland bench: " << drawn.error().message << "\n";
    return 2;
  }
  std::cout << (args.folder / "report.html").string() << ": " << *drawn;
  return 0;
}

CLI::App* addSections(CLI::App& app, SectionArguments& args) {
  CLI::App* sub = app.add_subcommand("sections", "refinement, adaptation and the error of every frame");
  apps::addFlightOptions(*sub, args.flight);
  sub->add_option("--measure-every", args.measure_every,
                  "judge one in so many shown frames; more if that shares a factor with the frames per keyframe")
      ->type_name(apps::whole("N"))
      ->check(apps::within(1, 1000))
      ->capture_default_str();
  sub->add_option("--triangles", args.triangles, "in the mean, whatever tolerance that takes; instead of --tau")
      ->type_name(apps::number("N"))
      ->check(apps::within(100.0, 1e8))
      ->excludes("--tau");
  sub->add_flag("!--no-errors", args.has_errors, "leave out the oracle; costs only");
  return sub;
}

CLI::App* addRefine(CLI::App& app, RefineArguments& args) {
  CLI::App* sub = app.add_subcommand("refine", "refinement from scratch, beside MARTINI on the same heights");
  apps::addFlightOptions(*sub, args.flight);
  sub->add_option("--martini", args.martini, "folder of martini.mjs and its node_modules")
      ->type_name(apps::folder("DIR"));
  return sub;
}

CLI::App* addWire(CLI::App& app, WireArguments& args) {
  CLI::App* sub = app.add_subcommand("wire", "bits and processor time of what a flight with the known path sends");
  apps::addFlightOptions(*sub, args.flight);
  sub->add_option("--peer-samples", args.peers.samples, "meshes in flight that the other codecs get")
      ->type_name(apps::whole("N"))
      ->check(apps::within(1, 1000))
      ->capture_default_str();
  sub->add_option("--wasm-decoder", args.wasm_decoder, "module of the wasm preset that decodes")
      ->type_name(apps::file("FILE.wasm"));
  sub->add_option("--quantized-mesh", args.peers.quantized_mesh, "folder of decode.mjs and its node_modules")
      ->type_name(apps::folder("DIR"));
  sub->add_flag("!--no-peers", args.has_peers, "leave out the other codecs");
  return sub;
}

CLI::App* addClient(CLI::App& app, ClientArguments& args) {
  CLI::App* sub = app.add_subcommand("client", "what keyframes cost a client: decoding, meshes, uploads");
  apps::addFlightOptions(*sub, args.flight);
  sub->add_option("--wasm-mesher", args.wasm_mesher, "module of the wasm preset that makes meshes")
      ->type_name(apps::file("FILE.wasm"));
  return sub;
}

int print(const Result<Report>& report, apps::ReportFormat format) {
  if (!report) {
    std::cerr << "foreland bench: " << report.error().message << "\n";
    return 2;
  }
  std::cout << apps::text(*report, format);
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{"Measures what the engine costs and whether it keeps its error guarantee.", "foreland bench"};
  app.require_subcommand(1);
  SectionArguments section_args;
  RefineArguments refine_args;
  WireArguments wire_args;
  ClientArguments client_args;
  apps::SurfaceArguments surface_args;
  apps::OcclusionArguments occlusion_args;
  apps::AnimatedArguments animated_args;
  apps::LatencyArguments latency_args;
  apps::CalibrateArguments calibrate_args;
  ReportArguments report_args;
  apps::LoadArguments load_args;
  apps::RunArguments run_args;
  apps::TilesArguments tiles_args;
  apps::DrapeArguments drape_args;
  apps::KeyframesArguments keyframes_args;
  apps::RivalsArguments rivals_args;
  apps::CostArguments cost_args;
  const CLI::App *on_sections = addSections(app, section_args), *on_refine = addRefine(app, refine_args),
                 *on_wire = addWire(app, wire_args), *on_occlusion = apps::addOcclusion(app, occlusion_args),
                 *on_animated = apps::addAnimated(app, animated_args),
                 *on_latency = apps::addLatency(app, latency_args),
                 *on_calibrate = apps::addCalibrate(app, calibrate_args), *on_report = addReport(app, report_args),
                 *on_load = apps::addLoad(app, load_args), *on_run = apps::addRun(app, run_args),
                 *on_tiles = apps::addTiles(app, tiles_args), *on_client = addClient(app, client_args),
                 *on_drape = apps::addDrape(app, drape_args), *on_keyframes = apps::addKeyframes(app, keyframes_args),
                 *on_rivals = apps::addRivals(app, rivals_args), *on_cost = apps::addCost(app, cost_args);
  apps::addSurfaces(app, surface_args);
  const auto exit_code =
      apps::parseCommandLine(app, argc, argv,
                             {{"bits and processor time of a flight", "foreland bench wire hills.fls --seconds 20"},
                              {"an experiment, and its page", "foreland bench latency hills.fls --out latency"},
                              {"", "foreland bench report latency"}});
  if (exit_code) return *exit_code;
  latency_args.experiment.command = load_args.experiment.command = tiles_args.experiment.command =
      drape_args.experiment.command = apps::commandText(argc, argv);
  if (*on_tiles) return print(apps::tiles(tiles_args), tiles_args.flight.format);
  if (*on_drape) return print(apps::drape(drape_args), drape_args.flight.format);
  if (*on_keyframes) return print(apps::keyframes(keyframes_args), keyframes_args.flight.format);
  if (*on_rivals) return print(apps::rivals(rivals_args), rivals_args.flight.format);
  if (*on_cost) return print(apps::cost(cost_args), cost_args.format);
  if (*on_run) return print(apps::runExperiment(run_args), apps::ReportFormat::kText);
  if (*on_client) return print(clientCosts(client_args), client_args.flight.format);
  if (*on_load) return print(apps::load(load_args), load_args.format);
  if (*on_latency) return print(apps::latency(latency_args), latency_args.flight.format);
  if (*on_report) return report(report_args);
  if (*on_calibrate) return print(apps::calibrate(calibrate_args), calibrate_args.format);
  if (*on_sections) return print(sections(section_args), section_args.flight.format);
  if (*on_refine) return print(refine(refine_args), refine_args.flight.format);
  if (*on_wire) return print(wire(wire_args), wire_args.flight.format);
  if (*on_animated) return print(apps::animated(animated_args), animated_args.flight.format);
  if (*on_occlusion) return print(apps::occlusion(occlusion_args), occlusion_args.flight.format);
  return print(apps::surfaces(surface_args), surface_args.format);
}

}  // namespace foreland

int main(int argc, char** argv) { return foreland::main(argc, argv); }
