#include "oracle/reference/plain_surface.h"

#include "oracle/surface/surface_truth.h"
#include "proto/topology/mesh_triangles.h"

namespace foreland::oracle {

using proto::NodeId;
using proto::Slot;

PlainSection plainRefine(const terrain::TrueSurface& surface, std::span<const proto::SurfaceRecord> records,
                         const proto::SurfaceMetric& metric) {
  const proto::MeshTopology& mesh = surface.topology;
  PlainSection section{std::vector<uint8_t>(mesh.slotCount(), 0), 0};
  std::vector<NodeId> active, next;
  const auto test = [&](NodeId n, Slot slot) {
    if (section.active[slot] || !metric.passes(proto::SurfaceBounds::of(records[slot], surface.quantum_m))) return;
    section.active[slot] = 1;
    ++section.nodes;
    next.push_back(n);
  };
  for (Slot slot = 0; slot < mesh.levelOffset(2 <= mesh.maxLevel() ? 2 : mesh.maxLevel() + 1); ++slot)
    if (const NodeId n = mesh.node(slot); !mesh.isBase(n)) test(n, slot);
  while (!next.empty()) {
    active.swap(next);
    next.clear();
    for (NodeId n : active)
      for (NodeId child : mesh.children(n)) test(child, mesh.slot(child));
  }
  return section;
}

size_t countTriangles(const terrain::TrueSurface& surface, const PlainSection& section) {
  size_t count = 0;
  proto::forEachTriangle(
      surface.topology, [&](NodeId n) { return section.holds(surface.topology, n); },
      [&](NodeId, NodeId, NodeId) { ++count; });
  return count;
}

namespace {

// Numbers vertices as they are met; those that are not active lie between their endpoints, which are vertices, too.
class MeshMaker {
 public:
  MeshMaker(const terrain::TrueSurface& surface, const PlainSection& section, MeshToDraw& mesh)
      : surface_(surface), topology_(surface.topology), section_(section), mesh_(mesh) {
    mesh.positions.clear();
    mesh.triangles.clear();
    mesh.numbers.assign(topology_.slotCount(), MeshToDraw::kNone);
    for (uint32_t v = 0; v < topology_.baseVertexCount(); ++v)
      mesh.positions.push_back(surface.position(proto::baseVertexId(v)));
  }
  void run() {
    proto::forEachTriangle(
        topology_, [&](NodeId n) { return section_.holds(topology_, n); },
        [&](NodeId a, NodeId b, NodeId c) {
          mesh_.triangles.push_back({number(a), number(b), number(c)});
        });
  }

 private:
  uint32_t number(NodeId v) {
    if (topology_.isBase(v)) return proto::baseVertexOf(v);
    const Slot slot = topology_.slot(v);
    if (mesh_.numbers[slot] != MeshToDraw::kNone) return mesh_.numbers[slot];
    const glm::dvec3 position = section_.active[slot] ? surface_.position(v) : middle(v);
    mesh_.positions.push_back(position);
    return mesh_.numbers[slot] = static_cast<uint32_t>(mesh_.positions.size() - 1);
  }
  glm::dvec3 middle(NodeId v) {
    const auto [a, b] = topology_.endpoints(v);
    const uint32_t from = number(a), to = number(b);
    return 0.5 * (mesh_.positions[from] + mesh_.positions[to]);
  }

  const terrain::TrueSurface& surface_;
  const proto::MeshTopology& topology_;
  const PlainSection& section_;
  MeshToDraw& mesh_;
};

}  // namespace

void meshToDraw(const terrain::TrueSurface& surface, const PlainSection& section, MeshToDraw& mesh) {
  MeshMaker(surface, section, mesh).run();
}

std::vector<DrawnTriangle> drawnTriangles(const terrain::TrueSurface& surface, const PlainSection& section) {
  const proto::MeshTopology& mesh = surface.topology;
  std::vector<glm::dvec3> drawn(mesh.slotCount());  // p_S of every node (THEORY section 2)
  const auto position = [&](NodeId v) { return mesh.isBase(v) ? surface.position(v) : drawn[mesh.slot(v)]; };
  terrain::forEachNode(mesh, [&](NodeId n, Slot slot) {
    const auto [a, b] = mesh.endpoints(n);
    drawn[slot] = section.active[slot] ? surface.position(n) : 0.5 * (position(a) + position(b));
  });
  std::vector<DrawnTriangle> triangles;
  for (uint32_t face = 0; face < mesh.base().faceCount(); ++face) {
    const auto visit = [&](NodeId a, NodeId b, NodeId c) {
      DrawnTriangle t{face, {}, {position(a), position(b), position(c)}};
      const NodeId corners[3] = {a, b, c};
      for (size_t i = 0; i < 3; ++i) t.weights[i] = surfacePoint(mesh.facePointIn(face, corners[i])).weights;
      triangles.push_back(t);
    };
    proto::forEachTriangleOf(
        mesh, face, [&](NodeId n) { return section.holds(mesh, n); }, visit);
  }
  return triangles;
}

}  // namespace foreland::oracle
