#include "apps/bench_surfaces.h"

#include <iostream>
#include <nlohmann/json.hpp>

#include "apps/options.h"
#include "bench/surfaces/report.h"
#include "terrain/surface/shapes.h"

namespace foreland::apps {

CLI::App* addSurfaces(CLI::App& app, SurfaceArguments& args) {
  CLI::App* surfaces = app.add_subcommand("surfaces", "faces, errors and work along a session around a surface");
  const auto pixels = CLI::Range(0.01, 1000.0) & isFinite();
  surfaces->add_option("--shape", args.shape, "sphere, torus or both")
      ->check(CLI::IsMember({"sphere", "torus", "both"}))
      ->capture_default_str();
  surfaces->add_option("--halvings", args.halvings, "of each base edge; the torus has one fewer")
      ->check(CLI::Range(2, 8))
      ->capture_default_str();
  surfaces->add_option("--silhouette", args.session.silhouette_px, "tolerance in pixels, on silhouettes")
      ->check(pixels)
      ->capture_default_str();
  surfaces->add_option("--interior", args.session.interior_px, "tolerance in pixels elsewhere")
      ->check(pixels)
      ->capture_default_str();
  surfaces->add_option("--frames", args.session.turning_frames, "of turning; half as many of coming near")
      ->check(CLI::Range(2, 10000))
      ->capture_default_str();
  surfaces->add_flag("--json", args.json, "print JSON");
  return surfaces;
}

int runSurfaces(const SurfaceArguments& args) {
  bench::SurfaceSession session = args.session;
  session.zoom_frames = session.turning_frames / 2;
  nlohmann::ordered_json report;
  const auto measure = [&](const char* name, const Result<terrain::TrueSurface>& surface) {
    if (args.shape != name && args.shape != "both") return true;
    if (!surface) {
      std::cerr << "foreland bench: " << surface.error().message << "\n";
      return false;
    }
    report[name] = bench::surfaceReport(*surface, session);
    return true;
  };
  if (!measure("sphere", terrain::makeSphere(1, {.halvings = args.halvings})) ||
      !measure("torus", terrain::makeTorus({}, {.halvings = args.halvings - 1})))
    return 2;
  if (args.json) {
    std::cout << report.dump(2) << "\n";
    return 0;
  }
  for (const auto& [shape, figures] : report.items())
    for (const auto& [key, value] : figures.items()) std::cout << shape << " " << key << "  " << value << "\n";
  return 0;
}

}  // namespace foreland::apps
