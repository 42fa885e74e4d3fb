#include "apps/remesh/remesh_report.h"

#include <cinttypes>
#include <cstdio>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <nlohmann/json.hpp>

#include "terrain/compare/deviation.h"
#include "terrain/surface/full_mesh.h"

namespace foreland::apps {

namespace {

constexpr double kTolerance = 1e-4;  // of the diagonal

// All that the model's file has: the original's triangles, and the lines that faces without area are.
struct GivenMesh {
  std::vector<glm::dvec3> positions;
  std::vector<terrain::Triangle> faces;
};

GivenMesh givenMesh(const terrain::Model& model, const terrain::Original& original) {
  GivenMesh given{original.positions, original.faces};
  for (terrain::Triangle line : original.degenerate) {
    for (uint32_t& vertex : line) {
      given.positions.push_back(model.positions[vertex]);
      vertex = static_cast<uint32_t>(given.positions.size() - 1);
    }
    given.faces.push_back(line);
  }
  return given;
}

std::string solidsText(const RemeshReport& r) {
  char text[160];
  std::snprintf(text, sizeof(text), "%zu inner %s with %.1f %% of the volume; drawn at most %.4g off",
                r.solids.solids.size(), r.solids.solids.size() == 1 ? "solid" : "solids", 100 * r.solids.volume_share,
                r.largest_error);
  if (r.solids.solids.empty())
    std::snprintf(text, sizeof(text), "no inner solids: %s; drawn at most %.4g off", r.why_no_solids.c_str(),
                  r.largest_error);
  return text;
}

}  // namespace

std::vector<std::string> repairNotes(const terrain::Original& original) {
  std::vector<std::string> notes;
  const auto add = [&](uint64_t count, const char* one, const char* several) {
    if (count > 0) notes.push_back(std::to_string(count) + (count == 1 ? one : several));
  };
  const terrain::Repairs& r = original.repairs;
  add(original.welded, " vertex welded to another at the same position",
      " vertices welded to others at the same position");
  add(r.repeated_corners, " repeated corner dropped", " repeated corners dropped");
  add(r.degenerate_faces, " face without area dropped", " faces without area dropped");
  add(r.duplicate_faces, " face dropped that repeats another", " faces dropped that repeat others");
  add(r.cut_edges, " edge cut at which the faces are not one surface",
      " edges cut at which the faces are not one surface");
  add(r.split_vertices, " vertex split at which parts touch", " vertices split at which parts touch");
  add(original.flipped, " face turned over", " faces turned over");
  return notes;
}

RemeshReport judgeRemesh(const terrain::Model& model, const terrain::Original& original,
                         const terrain::TrueSurface& surface, unsigned threads) {
  const proto::MeshTopology& topology = surface.topology;
  const terrain::FullMesh full(surface);
  RemeshReport r;
  r.original_vertices = original.positions.size(), r.original_triangles = original.faces.size();
  r.base_vertices = topology.base().vertexCount(), r.base_triangles = topology.base().faceCount();
  r.full_triangles = full.triangles().size();
  r.levels = topology.maxLevel();
  glm::dvec3 low = original.positions.front(), high = low;
  for (const glm::dvec3& p : original.positions) low = glm::min(low, p), high = glm::max(high, p);
  r.diagonal = glm::length(high - low);
  r.tolerance = kTolerance;
  std::vector<glm::dvec3> positions;
  for (size_t v = 0; v < topology.baseVertexCount() + size_t{topology.slotCount()}; ++v)
    positions.push_back(full.position(v));
  const terrain::MeshView of{original.positions, original.faces}, by{positions, full.triangles()};
  const terrain::ClosestPoint closest_original(of), closest_surface(by);
  const GivenMesh given = givenMesh(model, original);
  const double tolerance = kTolerance * r.diagonal;
  r.to_original = terrain::largestDistance(by, closest_original, tolerance, threads) / r.diagonal;
  r.to_surface =
      terrain::largestDistance({given.positions, given.faces}, closest_surface, tolerance, threads) / r.diagonal;
  r.flipped = terrain::findFlipped(by, closest_original, threads).size();
  r.flipped_as_given = r.flipped;
  if (original.flipped > 0) {
    const std::vector<terrain::Triangle> as_given = terrain::facesAsGiven(original);
    const terrain::ClosestPoint closest_given({original.positions, as_given});
    r.flipped_as_given = terrain::findFlipped(by, closest_given, threads).size();
  }
  r.welded = original.welded, r.turned = original.flipped, r.repairs = original.repairs;
  r.step = surface.quantum_m;
  return r;
}

std::string sentence(const RemeshReport& r) {
  char text[300];
  std::snprintf(text, sizeof(text),
                "%" PRIu64 " triangles became %" PRIu64 " base triangles with %d levels, %" PRIu64
                " in all; Hausdorff distance %.4f %% of the diagonal; %" PRIu64 " triangles flipped",
                r.original_triangles, r.base_triangles, r.levels, r.full_triangles, 100 * r.hausdorff(), r.flipped);
  return text;
}

void printReport(const RemeshReport& r, const std::filesystem::path& output, uint64_t id, bool as_json) {
  if (!as_json) {
    std::printf("%s: %" PRIu64 " base triangles, %d levels, %" PRIu64
                " triangles; %.4f %% of the diagonal off, %" PRIu64 " flipped; image %u x %u; %.1f s\n",
                output.c_str(), r.base_triangles, r.levels, r.full_triangles, 100 * r.hausdorff(), r.flipped,
                r.atlas.width(), r.atlas.height(), r.seconds);
    std::printf("  %s\n", solidsText(r).c_str());
    for (const PoseReport& pose : r.poses)
      std::printf("  pose %s: %.4f %% of the diagonal off\n", pose.date.c_str(), 100 * pose.hausdorff);
    return;
  }
  char name[17];
  std::snprintf(name, sizeof(name), "%016" PRIx64, id);
  nlohmann::ordered_json json;
  json["file"] = output.string();
  json["id"] = name;
  json["original"] = {{"vertices", r.original_vertices}, {"triangles", r.original_triangles}, {"diagonal", r.diagonal}};
  json["base"] = {{"vertices", r.base_vertices}, {"triangles", r.base_triangles}};
  json["levels"] = r.levels;
  json["full_triangles"] = r.full_triangles;
  json["hausdorff"] = {{"share_of_diagonal", r.hausdorff()},
                       {"surface_to_original", r.to_original},
                       {"original_to_surface", r.to_surface},
                       {"tolerance", r.tolerance}};
  json["flipped"] = r.flipped;
  json["flipped_as_given"] = r.flipped_as_given;
  json["repairs"] = {{"welded_vertices", r.welded},
                     {"repeated_corners", r.repairs.repeated_corners},
                     {"degenerate_faces", r.repairs.degenerate_faces},
                     {"duplicate_faces", r.repairs.duplicate_faces},
                     {"cut_edges", r.repairs.cut_edges},
                     {"split_vertices", r.repairs.split_vertices},
                     {"turned_faces", r.turned}};
  json["notes"] = r.notes;
  json["step"] = r.step;
  json["poses"] = nlohmann::ordered_json::array();
  for (const PoseReport& pose : r.poses)
    json["poses"].push_back({{"date", pose.date}, {"share_of_diagonal", pose.hausdorff}});
  json["image"] = {{"width", r.atlas.width()}, {"height", r.atlas.height()}, {"texels_per_base_edge", r.atlas.side}};
  json["inner_solids"] = {{"count", r.solids.solids.size()},
                          {"volume_share", r.solids.volume_share},
                          {"largest_error", r.largest_error},
                          {"why_none", r.why_no_solids}};
  json["seconds"] = r.seconds;
  std::printf("%s\n", json.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace).c_str());
}

}  // namespace foreland::apps
