#include "lab/apps/bench_surfaces.h"

#include <optional>

#include "apps/options/options.h"
#include "lab/surfaces/model.h"
#include "lab/surfaces/report.h"
#include "terrain/surface/shapes.h"

namespace foreland::apps {

CLI::App* addSurfaces(CLI::App& app, SurfaceArguments& args) {
  CLI::App* surfaces = app.add_subcommand("surfaces", "faces, errors and work along a session around a surface");
  const auto pixels = within(0.01, 1000.0);
  surfaces->add_option("MODEL", args.models, "surface, OBJ or PLY files, in place of the shapes")
      ->type_name(file("MODEL"))
      ->check(CLI::ExistingFile);
  surfaces->add_option("--base-triangles", args.base_triangles, "of a model's base mesh")
      ->type_name(whole("N"))
      ->check(within(4, 100'000))
      ->capture_default_str();
  surfaces->add_option("--shape", args.shape, "which of the built-in ones")
      ->check(oneOf({"sphere", "torus", "both"}))
      ->capture_default_str();
  surfaces->add_option("--halvings", args.halvings, "of each base edge; tori and models have one fewer")
      ->type_name(whole("N"))
      ->check(within(2, 8))
      ->capture_default_str();
  surfaces->add_option("--silhouette", args.session.silhouette_px, "tolerance in pixels, on silhouettes")
      ->type_name(number("PX"))
      ->check(pixels)
      ->capture_default_str();
  surfaces->add_option("--interior", args.session.interior_px, "tolerance in pixels elsewhere")
      ->type_name(number("PX"))
      ->check(pixels)
      ->capture_default_str();
  surfaces->add_option("--frames", args.session.turning_frames, "of turning; half as many of coming near")
      ->type_name(whole("N"))
      ->check(within(2, 10'000))
      ->capture_default_str();
  surfaces->add_flag_callback(
      "--json", [&args] { args.format = apps::ReportFormat::kJson; }, "print JSON");
  return surfaces;
}

namespace {

// Makes the surfaces that the arguments name and calls visit(name, surface) for each, until it returns false.
template <class Visit>
bool forEachSurface(const SurfaceArguments& args, const Visit& visit) {
  for (const std::string& model : args.models) {
    const auto surface = lab::surfaceOfModel(model, args.base_triangles, args.halvings - 1);
    if (!visit(model, surface)) return false;
  }
  const auto isAsked = [&](const char* shape) {
    return args.models.empty() && (args.shape == shape || args.shape == "both");
  };
  if (isAsked("sphere") && !visit("sphere", terrain::makeSphere(1, {.halvings = args.halvings}))) return false;
  return !isAsked("torus") || visit("torus", terrain::makeTorus({}, {.halvings = args.halvings - 1}));
}

}  // namespace

Result<nlohmann::ordered_json> surfaces(const SurfaceArguments& args) {
  lab::SurfaceSession session = args.session;
  session.zoom_frames = session.turning_frames / 2;
  nlohmann::ordered_json report;
  std::optional<Error> error;
  forEachSurface(args, [&](const std::string& name, const Result<terrain::TrueSurface>& surface) {
    if (surface)
      report[name] = lab::surfaceReport(*surface, session);
    else
      error = surface.error();
    return surface.ok();
  });
  if (error) return *error;
  return report;
}

}  // namespace foreland::apps
