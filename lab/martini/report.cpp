#include "lab/martini/report.h"

#include <algorithm>
#include <array>

#include "lab/martini/refine_speed.h"
#include "lab/martini/rival.h"
#include "lab/martini/uniform.h"
#include "lab/programs/lab_folder.h"
#include "proto/refine/refine.h"

namespace foreland::lab {

namespace {

using nlohmann::ordered_json;

constexpr int kRounds = 3;  // before MARTINI, and again after it
// SOAR's refinement from scratch (Lindstrom and Pascucci): view-dependent and culled, on one core. As published, of
// other data on another machine; it is not measured here.
constexpr double kSoarPublished_mtri_per_s = 37;
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

ordered_json meshEntry(const MartiniMesh& mesh) {
  return {{"triangles", mesh.triangles},
          {"true_error_m", mesh.true_error_m},
          {"ms", mesh.ms},
          {"mtri_per_s", mesh.mtri_per_s}};
}

// Our refiner at the same error in metres everywhere, over the whole scene.
ordered_json uniformEntry(const server::Hierarchy& isotropic, double max_error_m) {
  const proto::View view = uniformView(isotropic, max_error_m);
  RefineTimer timer(isotropic, {view});
  timer.measure(2 * kRounds);
  const RefineSpeed speed = timer.speed();
  proto::RefineScratch scratch;
  proto::Section section;
  CHECK_TRUE(server::refine(isotropic, view, size_t{1} << 30, scratch, section));
  const std::optional<double> error = trueError_m(isotropic.scene(), section);
  return {{"max_error_m", max_error_m},
          {"triangles", speed.triangles},
          {"true_error_m", error ? ordered_json(*error) : ordered_json(nullptr)},
          {"ms", speed.ms},
          {"mtri_per_s", speed.mtri_per_s}};
}

void addRival(const MartiniResult& martini, const std::string& key, double mtri_per_s, ordered_json& report) {
  double best = 0;
  for (const MartiniMesh& mesh : martini.meshes) best = std::max(best, mesh.mtri_per_s);
  const MartiniMesh& equal = martini.meshes.front();
  ordered_json entry = meshEntry(equal);
  entry.update({{"max_error_m", equal.max_error_m},
                {"best_mtri_per_s", best},
                {"ratio", mtri_per_s / equal.mtri_per_s},
                {"ratio_to_best", mtri_per_s / best},
                {"tables_ms", martini.tables_ms},
                {"tile_ms", martini.tile_ms},
                {"clear_ms", martini.clear_ms},
                {"grid_size", martini.grid_size},
                {"view_dependent", false},
                {"culled", false}});
  if (!martini.node.empty()) entry.update({{"version", martini.version}, {"node", martini.node}});
  report[key] = std::move(entry);
}

ordered_json sameError(const std::shared_ptr<const terrain::Scene>& scene, const MartiniResult& plain,
                       const Result<MartiniResult>& javascript) {
  const server::Hierarchy isotropic(scene, proto::ErrorBound::kSphere);
  ordered_json rows = ordered_json::array();
  for (size_t i = 0; i < plain.meshes.size(); ++i) {
    rows.push_back(uniformEntry(isotropic, plain.meshes[i].max_error_m));
    rows.back()["martini"] = meshEntry(plain.meshes[i]);
    if (javascript) rows.back()["martini_javascript"] = meshEntry(javascript->meshes[i]);
  }
  return rows;
}

}  // namespace

std::filesystem::path martiniSources() { return labFolder() / "martini"; }

ordered_json refineReport(const std::shared_ptr<const terrain::Scene>& scene, const std::vector<proto::View>& views,
                          const std::filesystem::path& martini_folder) {
  const server::Hierarchy hierarchy(scene);
  RefineTimer timer(hierarchy, views);
  timer.measure(kRounds);
  const auto requests = requestsFor(hierarchy, timer.speed().triangles, middle(views));
  const MartiniResult plain = runPlainMartini(*scene, requests);
  const auto javascript = runMartini(*scene, martini_folder, requests);
  timer.measure(kRounds);
  const RefineSpeed speed = timer.speed();
  ordered_json report{{"samples", {scene->grid().shape().samples_x, scene->grid().shape().samples_y}},
                      {"views", views.size()},
                      {"nodes", speed.nodes},
                      {"triangles", speed.triangles},
                      {"refine_ms", speed.ms},
                      {"refine_mtri_per_s", speed.mtri_per_s},
                      {"refine_mtri_per_s_deviation", speed.mtri_per_s_deviation},
                      {"soar_published_mtri_per_s", kSoarPublished_mtri_per_s}};
  addRival(plain, "martini", speed.mtri_per_s, report);
  if (javascript) {
    addRival(*javascript, "martini_javascript", speed.mtri_per_s, report);
  } else {
    report["martini_javascript"] = nullptr;
    report["martini_javascript_skipped"] = javascript.error().message;
  }
  report["same_error"] = sameError(scene, plain, javascript);
  return report;
}

}  // namespace foreland::lab
