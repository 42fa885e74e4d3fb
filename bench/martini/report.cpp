#include "bench/martini/report.h"

#include <algorithm>
#include <array>

#include "bench/martini/refine_speed.h"
#include "bench/martini/rival.h"
#include "bench/martini/uniform.h"
#include "proto/refine/refine.h"

namespace foreland::bench {

namespace {

using nlohmann::ordered_json;

constexpr int kRounds = 3;  // before MARTINI, and again after it
// Times the triangles of a section; MARTINI is at its best with many.
constexpr std::array<double, 2> kSweep = {4, 16};

// The view whose error in metres, kept everywhere, is what a refiner without views needs to be as good.
proto::View middle(const std::vector<proto::View>& views) { return views[views.size() / 2]; }

std::vector<MartiniRequest> requestsFor(const server::Hierarchy& hierarchy, double triangles, const proto::View& view) {
  const double intervals = martiniGridSize(hierarchy.grid().shape()) - 1, everything = 2 * intervals * intervals;
  std::vector<MartiniRequest> requests{{.triangles = triangles}};
  for (double times : kSweep)
    if (times * triangles < everything) requests.push_back({.triangles = times * triangles});
  requests.push_back({.max_error_m = nearestError_m(hierarchy, view)});
  return requests;
}

// Our refiner at the same error in metres everywhere, over the whole scene.
ordered_json uniformEntry(const server::Hierarchy& isotropic, const MartiniMesh& rival) {
  const proto::View view = uniformView(isotropic, rival.max_error_m);
  RefineTimer timer(isotropic, {view});
  timer.measure(2 * kRounds);
  const RefineSpeed speed = timer.speed();
  proto::RefineScratch scratch;
  proto::Section section;
  CHECK_TRUE(server::refine(isotropic, view, size_t{1} << 30, scratch, section));
  const std::optional<double> error = trueError_m(isotropic.scene(), section);
  return {{"max_error_m", rival.max_error_m},
          {"triangles", speed.triangles},
          {"true_error_m", error ? ordered_json(*error) : ordered_json(nullptr)},
          {"ms", speed.ms},
          {"mtri_per_s", speed.mtri_per_s},
          {"martini",
           {{"triangles", rival.triangles},
            {"true_error_m", rival.true_error_m},
            {"ms", rival.ms},
            {"mtri_per_s", rival.mtri_per_s}}}};
}

void addMartini(const std::shared_ptr<const terrain::Scene>& scene, const MartiniResult& martini, double mtri_per_s,
                ordered_json& report) {
  double best = 0;
  for (const MartiniMesh& mesh : martini.meshes) best = std::max(best, mesh.mtri_per_s);
  const MartiniMesh& equal = martini.meshes.front();
  report.update({{"martini_mtri_per_s", equal.mtri_per_s},
                 {"ratio", mtri_per_s / equal.mtri_per_s},
                 {"martini_best_mtri_per_s", best},
                 {"ratio_to_best", mtri_per_s / best},
                 {"martini",
                  {{"version", martini.version},
                   {"node", martini.node},
                   {"grid_size", martini.grid_size},
                   {"tables_ms", martini.tables_ms},
                   {"tile_ms", martini.tile_ms},
                   {"clear_ms", martini.clear_ms},
                   {"triangles", equal.triangles},
                   {"max_error_m", equal.max_error_m},
                   {"ms", equal.ms},
                   {"view_dependent", false},
                   {"culled", false}}}});
  const server::Hierarchy isotropic(scene, proto::ErrorBound::kSphere);
  report["same_error"] = ordered_json::array();
  for (const MartiniMesh& mesh : martini.meshes) report["same_error"].push_back(uniformEntry(isotropic, mesh));
}

}  // namespace

std::filesystem::path martiniSources() { return std::filesystem::path(FORELAND_SOURCE_DIR) / "bench/martini"; }

ordered_json refineReport(const std::shared_ptr<const terrain::Scene>& scene, const std::vector<proto::View>& views,
                          const std::filesystem::path& martini_folder) {
  const server::Hierarchy hierarchy(scene);
  RefineTimer timer(hierarchy, views);
  timer.measure(kRounds);
  const double triangles = timer.speed().triangles;
  const auto martini = runMartini(*scene, martini_folder, requestsFor(hierarchy, triangles, middle(views)));
  timer.measure(kRounds);
  const RefineSpeed speed = timer.speed();
  ordered_json report{{"samples", {scene->grid().shape().samples_x, scene->grid().shape().samples_y}},
                      {"views", views.size()},
                      {"nodes", speed.nodes},
                      {"triangles", speed.triangles},
                      {"refine_ms", speed.ms},
                      {"refine_mtri_per_s", speed.mtri_per_s},
                      {"refine_mtri_per_s_deviation", speed.mtri_per_s_deviation}};
  if (martini) {
    addMartini(scene, *martini, speed.mtri_per_s, report);
  } else {
    report.update({{"martini_mtri_per_s", nullptr},
                   {"ratio", nullptr},
                   {"martini", nullptr},
                   {"martini_skipped", martini.error().message}});
  }
  return report;
}

}  // namespace foreland::bench
