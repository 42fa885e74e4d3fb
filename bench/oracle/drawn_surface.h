// A client's mesh at one moment, as terrain/render casts rays on it: where the owner of the data, who knows no client,
// and the client, who knows no data, are introduced to each other. Pure; any thread; O(vertices).
#pragma once

#include <glm/common.hpp>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

#include "client/mesh/keyframe_mesh.h"
#include "terrain/render/ray_caster.h"

namespace foreland::bench {

// Which vertices triangles refer to: others lie beyond the data, or are places that nobody uses.
inline std::vector<bool> drawnVertices(size_t count, std::span<const uint32_t> indices) {
  std::vector<bool> is_drawn(count);
  for (uint32_t vertex : indices) is_drawn[vertex] = true;
  return is_drawn;
}

inline terrain::DrawnSurface::Triangles drawnTriangles(const client::BlendMesh& mesh, double weight) {
  terrain::DrawnSurface::Triangles out{{}, {}, mesh.parameters, mesh.indices};
  out.positions.reserve(mesh.from_positions.size());
  out.heights_m.reserve(mesh.from_positions.size());
  for (size_t v = 0; v < mesh.from_positions.size(); ++v) {
    const glm::vec4 at(glm::mix(glm::dvec4(mesh.from_positions[v]), glm::dvec4(mesh.to_positions[v]), weight));
    out.positions.emplace_back(at);
    out.heights_m.push_back(at.w);
  }
  return out;
}

// `weight` is 0 at the mesh's earlier end and 1 at its later one.
inline terrain::DrawnSurface drawnSurface(const client::KeyframeMesh& mesh, double weight) {
  terrain::DrawnSurface drawn{mesh.origin, drawnTriangles(mesh, weight), drawnTriangles(mesh.objects, weight), {}};
  for (const client::ObjectPart& part : mesh.object_parts) drawn.object_begin.push_back(part.first_index / 3);
  return drawn;
}

}  // namespace foreland::bench
