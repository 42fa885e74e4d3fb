// foreland bench: what the engine costs and whether it keeps its promises, beside a named rival where there is one.
// bench/README.md says how each figure is measured.
#include <CLI/CLI.hpp>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <iostream>
#include <nlohmann/json.hpp>
#include <string>

#include "apps/bench_surfaces.h"
#include "apps/options.h"
#include "bench/martini/report.h"
#include "bench/sections/measure.h"
#include "bench/wire/measure.h"
#include "bench/wire/peer_report.h"
#include "bench/wire/wasm_decoder.h"
#include "server/session/world.h"
#include "server/view/tour.h"

namespace foreland {
namespace {

struct Arguments {
  std::string scene, tour = "survey", martini = bench::martiniSources();
  bench::FlightOptions flight;
  uint32_t frames_per_second = 60, measure_every = 6;
  double triangles = 0;  // 0: as many as the tolerance takes
  bench::PeerOptions peers{.quantized_mesh = bench::peerSources()};
  std::filesystem::path wasm_decoder = bench::wasmDecoderPath();
  bool json = false, errors = true, with_peers = true;
};

int fail(const std::string& message) {
  std::cerr << "foreland bench: " << message << "\n";
  return 2;
}

void print(const nlohmann::ordered_json& report, bool json) {
  if (json) {
    std::cout << report.dump(2) << "\n";
    return;
  }
  for (const auto& [key, value] : report.items()) std::cout << key << "  " << value << "\n";
}

// The tolerance that the flight is to be measured with.
Result<double> tauOf(const Arguments& args, const server::Hierarchy& hierarchy, const proto::Path& path) {
  if (args.triangles == 0) return args.flight.tau_px;
  return bench::tauForTriangles(hierarchy, bench::keyframeViews(path, args.flight, bench::Promise::kEveryFrame),
                                args.triangles);
}

int runSections(Arguments args) {
  auto scene = terrain::Scene::open(args.scene);
  if (!scene) return fail(scene.error().message);
  const server::Hierarchy hierarchy(*scene), isotropic(*scene, proto::ErrorBound::kSphere);
  auto path = server::planTour(**scene, args.tour, args.flight.seconds + 1);
  if (!path) return fail(path.error().message);
  const auto tau_px = tauOf(args, hierarchy, *path);
  if (!tau_px) return fail(tau_px.error().message);
  args.flight.tau_px = *tau_px;
  const auto plain = bench::keyframeViews(*path, args.flight, bench::Promise::kKeyframesOnly);
  const auto promised = bench::keyframeViews(*path, args.flight, bench::Promise::kEveryFrame);

  const bench::SectionCosts costs = bench::measureCosts(hierarchy, promised);
  const double triangles_plain = bench::meanTriangles(hierarchy, plain),
               triangles = bench::meanTriangles(hierarchy, promised);
  const double triangles_sphere = bench::meanTriangles(isotropic, promised);
  const double one = bench::keyframesPerSecond(hierarchy, promised, 1),
               two = bench::keyframesPerSecond(hierarchy, promised, 2);
  nlohmann::ordered_json report{{"tour", args.tour},
                                {"tau_px", args.flight.tau_px},
                                {"keyframe_ms", args.flight.keyframe_interval.toMilliseconds()},
                                {"nodes", costs.nodes},
                                {"triangles", costs.triangles},
                                {"changed_fraction", costs.changed_fraction},
                                {"refine_mtri_per_s", costs.refine_mtri_per_s},
                                {"refine_ms", costs.refine_ms},
                                {"adapt_ms", costs.adapt_ms},
                                {"adapt_us_per_change", costs.adapt_us_per_change},
                                {"ratio", costs.ratio},
                                {"keyframes_per_s_per_core", costs.keyframes_per_s_per_core},
                                {"bytes_per_node", costs.bytes_per_node},
                                {"allocations_in_steady_state", costs.allocations},
                                {"two_threads_over_one", two / one},
                                {"promise_triangle_overhead", triangles / triangles_plain - 1},
                                {"spheroid_triangle_saving", 1 - triangles / triangles_sphere}};
  if (args.errors) {
    const double frames = args.frames_per_second * args.flight.keyframe_interval.toSeconds();
    const bench::SectionErrors errors = bench::measureErrors(
        hierarchy, promised, *path, args.flight, static_cast<uint32_t>(std::lround(frames)), args.measure_every);
    report.update({{"max_error_px_keyframes", errors.max_error_px_keyframes},
                   {"max_error_px_frames", errors.max_error_px_frames},
                   {"measured_frames", errors.frames},
                   {"frames_over_tau", errors.frames_over_tau},
                   {"lod_motion_px_per_frame", errors.lod_motion_px_per_frame},
                   {"lod_motion_px_per_frame_p99", errors.lod_motion_px_per_frame_p99},
                   {"cracks", errors.cracks}});
  }
  print(report, args.json);
  return 0;
}

int runRefine(const Arguments& args) {
  auto scene = terrain::Scene::open(args.scene);
  if (!scene) return fail(scene.error().message);
  auto path = server::planTour(**scene, args.tour, args.flight.seconds + 1);
  if (!path) return fail(path.error().message);
  const auto views = bench::keyframeViews(*path, args.flight, bench::Promise::kEveryFrame);
  nlohmann::ordered_json report{{"tour", args.tour}, {"tau_px", args.flight.tau_px}};
  report.update(bench::refineReport(*scene, views, args.martini));
  if (report["martini"].is_null())
    std::cerr << "foreland bench: MARTINI skipped: " << report["martini_skipped"].get<std::string>() << "\n";
  print(report, args.json);
  return 0;
}

// The flight decoded in WebAssembly; null, with the reason, where that cannot be.
Result<nlohmann::ordered_json> wasmReport(const Arguments& args, const server::Hierarchy& hierarchy,
                                          const std::vector<bench::RecordedKeyframe>& flight,
                                          const bench::WireCosts& costs) {
  proto::Welcome welcome = server::welcomeTo(hierarchy);
  welcome.tau_px = args.flight.tau_px;
  welcome.keyframe_interval = args.flight.keyframe_interval;
  const auto times = bench::decodeInWasm(args.wasm_decoder, welcome, flight);
  nlohmann::ordered_json report{{"decode_wasm_mnodes_per_s", nullptr}, {"first_decode_wasm_mnodes_per_s", nullptr}};
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

int runWire(const Arguments& args) {
  auto scene = terrain::Scene::open(args.scene);
  if (!scene) return fail(scene.error().message);
  auto objects = server::objectsOf(*scene);
  if (!objects) return fail(objects.error().message);
  const server::Hierarchy hierarchy(*scene, proto::ErrorBound::kSpheroid, std::move(*objects));
  auto path = server::planTour(**scene, args.tour, args.flight.seconds + 1);
  if (!path) return fail(path.error().message);
  const auto views = bench::keyframeViews(*path, args.flight, bench::Promise::kEveryFrame);
  const auto flight = bench::recordFlight(hierarchy, views, args.flight.keyframe_interval);
  const bench::WireCosts costs = bench::measureWire(hierarchy, views, flight, args.flight.keyframe_interval);
  nlohmann::ordered_json report{{"tour", args.tour},
                                {"tau_px", args.flight.tau_px},
                                {"keyframe_ms", args.flight.keyframe_interval.toMilliseconds()},
                                {"keyframes", costs.keyframes},
                                {"nodes_added", costs.nodes_added},
                                {"nodes_removed", costs.nodes_removed},
                                {"bits_per_added_node", costs.bits_per_added_node},
                                {"height_bits", costs.height_bits},
                                {"structure_bits", costs.structure_bits},
                                {"asked_per_added", costs.asked_per_added},
                                {"framing_bits", costs.framing_bits},
                                {"framing_share", costs.framing_share},
                                {"first_section_nodes", costs.first_section_nodes},
                                {"first_section_bytes", costs.first_section_bytes},
                                {"first_section_bits_per_node", costs.first_section_bits_per_node},
                                {"first_section_height_bits", costs.first_section_height_bits},
                                {"first_section_structure_bits", costs.first_section_structure_bits},
                                {"kbit_per_s", costs.kbit_per_s},
                                {"objects", hierarchy.objects().set.size()},
                                {"object_nodes_added", costs.object_nodes_added},
                                {"object_places", costs.object_places},
                                {"bits_per_object_node", costs.bits_per_object_node},
                                {"object_structure_bits", costs.object_structure_bits},
                                {"object_place_bits", costs.object_place_bits},
                                {"object_framing_bits", costs.object_framing_bits},
                                {"encode_mnodes_per_s", costs.encode_mnodes_per_s},
                                {"decode_mnodes_per_s", costs.decode_mnodes_per_s},
                                {"decode_beyond_adaptation_mnodes_per_s", costs.decode_beyond_adaptation_mnodes_per_s},
                                {"send_mnodes_per_s", costs.send_mnodes_per_s},
                                {"first_encode_mnodes_per_s", costs.first_encode_mnodes_per_s},
                                {"first_decode_mnodes_per_s", costs.first_decode_mnodes_per_s},
                                {"encode_ms", costs.encode_ms},
                                {"decode_ms", costs.decode_ms}};
  const auto wasm = wasmReport(args, hierarchy, flight, costs);
  if (!wasm) return fail(wasm.error().message);
  report.update(*wasm);
  if (report.contains("decode_wasm_skipped"))
    std::cerr << "foreland bench: WebAssembly skipped: " << report["decode_wasm_skipped"].get<std::string>() << "\n";
  if (args.with_peers) {
    auto peers = bench::peersReport(hierarchy, views, args.peers);
    if (!peers) return fail(peers.error().message);
    report["peers"] = std::move(peers).value();
    if (report["peers"].contains("quantized_mesh_skipped"))
      std::cerr << "foreland bench: quantized-mesh skipped: "
                << report["peers"]["quantized_mesh_skipped"].get<std::string>() << "\n";
  }
  print(report, args.json);
  return 0;
}

void addFlightOptions(CLI::App& app, Arguments& args, double& interval_ms) {
  app.add_option("scene", args.scene, "scene file (foreland build)")->required();
  app.add_option("--tour", args.tour, "survey, canyon, spin or orbit")->capture_default_str();
  app.add_option("--seconds", args.flight.seconds, "of flight")
      ->check(CLI::Range(1.0, 3600.0) & apps::isFinite())
      ->capture_default_str();
  app.add_option("--tau", args.flight.tau_px, "tolerance in pixels")
      ->check(CLI::Range(0.01, 1000.0) & apps::isFinite())
      ->capture_default_str();
  app.add_option("--keyframe-ms", interval_ms, "keyframe interval")
      ->check(CLI::Range(20.0, 10000.0) & apps::isFinite())
      ->capture_default_str();
  app.add_flag("--json", args.json, "print JSON");
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{"Measures what the engine costs and whether it keeps its promises.", "foreland bench"};
  app.require_subcommand(1);
  Arguments args;
  double interval_ms = 200;
  CLI::App* sections = app.add_subcommand("sections", "refinement, adaptation and the error of every frame");
  addFlightOptions(*sections, args, interval_ms);
  sections->add_option("--measure-every", args.measure_every, "put every n-th shown frame before the oracle")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  sections->add_option("--triangles", args.triangles, "in the mean, whatever tolerance that takes; instead of --tau")
      ->check(CLI::Range(100.0, 1e8) & apps::isFinite())
      ->excludes("--tau");
  sections->add_flag("!--no-errors", args.errors, "leave out the oracle; costs only");
  CLI::App* refine = app.add_subcommand("refine", "refinement from scratch, beside MARTINI on the same heights");
  addFlightOptions(*refine, args, interval_ms);
  refine->add_option("--martini", args.martini, "folder of martini.mjs and its node_modules");
  CLI::App* wire = app.add_subcommand("wire", "bits and processor time of what a flight with the known path sends");
  addFlightOptions(*wire, args, interval_ms);
  wire->add_option("--peer-samples", args.peers.samples, "meshes in flight that the other codecs get")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  wire->add_option("--wasm-decoder", args.wasm_decoder, "module of the wasm preset that decodes");
  wire->add_option("--quantized-mesh", args.peers.quantized_mesh, "folder of decode.mjs and its node_modules");
  wire->add_flag("!--no-peers", args.with_peers, "leave out the other codecs");
  apps::SurfaceArguments surface_args;
  const CLI::App* surfaces = apps::addSurfaces(app, surface_args);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& e) { return app.exit(e) == 0 ? 0 : 2; }
  args.flight.keyframe_interval = Duration::seconds(interval_ms / 1000);
  if (*wire) return runWire(args);
  if (*surfaces) return apps::runSurfaces(surface_args);
  return *refine ? runRefine(args) : runSections(args);
}

}  // namespace foreland

int main(int argc, char** argv) { return foreland::main(argc, argv); }
