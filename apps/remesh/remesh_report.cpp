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

}  // namespace

RemeshReport judgeRemesh(const terrain::Original& original, const terrain::TrueSurface& surface, unsigned threads) {
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
  const double tolerance = kTolerance * r.diagonal;
  r.to_original = terrain::largestDistance(by, closest_original, tolerance, threads) / r.diagonal;
  r.to_surface = terrain::largestDistance(of, closest_surface, tolerance, threads) / r.diagonal;
  r.flipped = terrain::findFlipped(by, closest_original, threads).size();
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
  json["step"] = r.step;
  json["image"] = {{"width", r.atlas.width()}, {"height", r.atlas.height()}, {"texels_per_base_edge", r.atlas.side}};
  json["seconds"] = r.seconds;
  std::printf("%s\n", json.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace).c_str());
}

}  // namespace foreland::apps
