#include "apps/info/info_surface.h"

#include <cinttypes>
#include <cstdio>

#include "apps/options/date.h"
#include "terrain/surface/surface.h"

namespace foreland::apps {

namespace {

using nlohmann::ordered_json;

struct Summary {
  std::string id;
  const char* rule;
  uint64_t border_edges = 0, nodes = 0, full_triangles = 0;
  glm::dvec3 low, high;
};

Summary summarise(const terrain::MappedSurface& surface) {
  const terrain::SurfaceHeader& h = surface.header();
  const proto::MeshTopology& topology = surface.topology();
  const proto::BaseMesh& base = topology.base();
  const bool is_quad = topology.rule() == proto::MeshRule::kQuadrisection;
  char id[17];
  std::snprintf(id, sizeof(id), "%016" PRIx64, surface.id());
  Summary s{.id = id, .rule = is_quad ? "quadrisection" : "bisection", .low = {}, .high = {}};
  s.border_edges = base.borderEdgeCount();
  terrain::forEachNode(topology, [&](proto::NodeId, proto::Slot) { ++s.nodes; });
  // Each halving of all edges makes four of a triangle; bisection begins with three for each face.
  s.full_triangles = (uint64_t{base.faceCount()} * (is_quad ? 1 : 3)) << (2 * topology.halvings());
  s.low = h.quantum_m * glm::dvec3(h.low[0], h.low[1], h.low[2]);
  s.high = h.quantum_m * glm::dvec3(h.high[0], h.high[1], h.high[2]);
  return s;
}

}  // namespace

std::string solidsText(const terrain::MappedSurface& surface) {
  const terrain::InnerSolids& inner = surface.innerSolids();
  const size_t count = inner.solids.size();
  char text[120];
  const double off = surface.largestError();
  if (count == 0)
    std::snprintf(text, sizeof(text), "none inside; drawn at most %.4g off", off);
  else
    std::snprintf(text, sizeof(text), "%zu inside, %.1f %% of the volume; drawn at most %.4g off", count,
                  100 * inner.volume_share, off);
  return text;
}

ordered_json describeSurface(const terrain::MappedSurface& surface) {
  const Summary s = summarise(surface);
  const proto::BaseMesh& base = surface.topology().base();
  ordered_json about;
  about["title"] = surface.about().title;
  about["id"] = s.id;
  about["base"] = {{"vertices", base.vertexCount()},
                   {"triangles", base.faceCount()},
                   {"edges", base.edgeCount()},
                   {"border_edges", s.border_edges}};
  about["rule"] = s.rule;
  about["levels"] = surface.topology().maxLevel();
  about["nodes"] = s.nodes;
  about["full_triangles"] = s.full_triangles;
  about["low"] = {s.low.x, s.low.y, s.low.z};
  about["high"] = {s.high.x, s.high.y, s.high.z};
  about["step"] = surface.quantumMetres();
  about["origin"] = {surface.origin().x, surface.origin().y, surface.origin().z};
  about["image"] = {{"width", surface.atlas().width()},
                    {"height", surface.atlas().height()},
                    {"texels_per_base_edge", surface.atlas().side}};
  about["largest_error"] = surface.largestError();
  about["inner_solids"] = {{"count", surface.innerSolids().solids.size()},
                           {"volume_share", surface.innerSolids().volume_share}};
  about["poses"] = ordered_json::array();
  for (const Time& time : surface.poseTimes()) about["poses"].push_back(dateText(time));
  about["notes"] = surface.about().notes;
  return about;
}

void printSurface(const std::string& path, const terrain::MappedSurface& surface) {
  const Summary s = summarise(surface);
  const proto::BaseMesh& base = surface.topology().base();
  std::printf("surface    %s\n", path.c_str());
  std::printf("title      %s\n", surface.about().title.c_str());
  std::printf("id         %s\n", s.id.c_str());
  std::printf("base       %u triangles, %u vertices, %s\n", base.faceCount(), base.vertexCount(),
              s.border_edges == 0 ? "closed" : (std::to_string(s.border_edges) + " border edges").c_str());
  std::printf("hierarchy  %s, %d levels, %" PRIu64 " nodes, %" PRIu64 " triangles in all\n", s.rule,
              surface.topology().maxLevel(), s.nodes, s.full_triangles);
  std::printf("box        (%.6g, %.6g, %.6g) to (%.6g, %.6g, %.6g), multiples of %g\n", s.low.x, s.low.y, s.low.z,
              s.high.x, s.high.y, s.high.z, surface.quantumMetres());
  if (const glm::dvec3 o = surface.origin(); o != glm::dvec3(0))
    std::printf("origin     (%.12g, %.12g, %.12g) of the model's coordinates; --object %s@here stands there\n", o.x,
                o.y, o.z, path.c_str());
  if (surface.atlas().side > 0)
    std::printf("image      %u x %u pixels, %u texels along a base edge\n", surface.atlas().width(),
                surface.atlas().height(), surface.atlas().side);
  std::printf("solids     %s\n", solidsText(surface).c_str());
  for (const Time& time : surface.poseTimes()) std::printf("pose       %s\n", dateText(time).c_str());
  for (const std::string& note : surface.about().notes) std::printf("note       %s\n", note.c_str());
}

}  // namespace foreland::apps
