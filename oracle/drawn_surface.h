// A client's mesh at one moment, as terrain/render casts rays on it: where the owner of the data, who knows no client,
// and the client, who knows no data, are introduced to each other. Pure; any thread; O(vertices).
#pragma once

#include <glm/common.hpp>
#include <glm/vec3.hpp>
#include <span>
#include <utility>
#include <vector>

#include "client/mesh/patch/keyframe_mesh.h"
#include "terrain/render/ray_caster.h"

namespace foreland::oracle {

// Which vertices triangles refer to: others lie beyond the data, or are places that nobody uses.
inline std::vector<bool> drawnVertices(size_t count, std::span<const uint32_t> indices) {
  std::vector<bool> is_drawn(count);
  for (uint32_t vertex : indices) is_drawn[vertex] = true;
  return is_drawn;
}

// Of the objects' triangles, object by object.
inline std::vector<uint32_t> objectIndices(const client::KeyframeMesh& mesh) {
  std::vector<uint32_t> out;
  for (const client::ObjectPart& part : mesh.object_parts) {
    const auto begin = mesh.objects.indices.begin() + part.first_index;
    out.insert(out.end(), begin, begin + part.index_count);
  }
  return out;
}

inline terrain::DrawnSurface::Triangles drawnTriangles(const client::BlendMesh& mesh, std::vector<uint32_t> indices,
                                                       double weight) {
  terrain::DrawnSurface::Triangles out{{}, {}, mesh.parameters, std::move(indices)};
  out.positions.reserve(mesh.from_positions.size());
  out.heights_m.reserve(mesh.from_positions.size());
  for (size_t v = 0; v < mesh.from_positions.size(); ++v) {
    const glm::vec4 at(mesh.at(v, weight));
    out.positions.emplace_back(at);
    out.heights_m.push_back(at.w);
  }
  return out;
}

// `weight` is 0 at the mesh's earlier end and 1 at its later one.
inline terrain::DrawnSurface drawnSurface(const client::KeyframeMesh& mesh, double weight) {
  terrain::DrawnSurface drawn{mesh.origin,
                              drawnTriangles(mesh, mesh.indices, weight),
                              drawnTriangles(mesh.objects, objectIndices(mesh), weight),
                              {}};
  uint32_t triangles = 0;
  for (const client::ObjectPart& part : mesh.object_parts) {
    drawn.object_begin.push_back(triangles);
    triangles += part.index_count / 3;
  }
  return drawn;
}

}  // namespace foreland::oracle
