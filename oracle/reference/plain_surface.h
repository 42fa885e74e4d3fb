// Surfaces refined and drawn in the plainest way: the reference that tests and measurements compare with. A section
// here is a flag for every slot. Pure; any thread; nothing is made to be fast but plainRefine, which touches what
// passes and its children only.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "oracle/surface/surface_oracle.h"
#include "proto/refine/surface/surface_metric.h"
#include "terrain/surface/surface.h"

namespace foreland::oracle {

struct PlainSection {
  std::vector<uint8_t> active;  // by slot
  size_t nodes = 0;

  bool holds(const proto::MeshTopology& mesh, proto::NodeId n) const { return active[mesh.slot(n)] != 0; }
};

// From scratch, level by level: nodes that pass, found from their parents.
PlainSection plainRefine(const terrain::TrueSurface& surface, std::span<const proto::SurfaceRecord> records,
                         const proto::SurfaceMetric& metric);

// Triangles of the section's mesh, cut at T-vertices.
size_t countTriangles(const terrain::TrueSurface& surface, const PlainSection& section);

// What a client would hand to a graphics card: each vertex once.
struct MeshToDraw {
  std::vector<glm::dvec3> positions;
  std::vector<std::array<uint32_t, 3>> triangles;
  std::vector<uint32_t> numbers;  // scratch: of each slot's vertex, or kNone
  static constexpr uint32_t kNone = 0xffffffffu;
};
void meshToDraw(const terrain::TrueSurface& surface, const PlainSection& section, MeshToDraw& mesh);

// What is drawn, for the oracle.
std::vector<DrawnTriangle> drawnTriangles(const terrain::TrueSurface& surface, const PlainSection& section);

}  // namespace foreland::oracle
