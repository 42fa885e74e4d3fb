// Collects the vertices that change in one patch: where each begins, when it is touched for the first time, and where
// it ends. A mesh has two ends, and the state of its vertices is brought from the last mesh's end to this one's
// beginning, then to its end; what is touched before beginDone() gets its beginning there. One owner.
#pragma once

#include "client/mesh/patch/blend_patch.h"
#include "client/mesh/patch/pack_normal.h"
#include "client/mesh/terrain/terrain_vertices.h"

namespace foreland::client {

class PatchWriter {
 public:
  PatchWriter(TerrainVertices& vertices, const glm::dvec3& origin, bool tells_moved, BlendPatch& out)
      : vertices_(vertices), origin_(origin), out_(out) {
    out_.tells_moved = tells_moved;
  }

  // To be called before the vertex moves, and before its normal turns.
  void touchPosition(uint32_t v) {
    TerrainVertex& vertex = vertices_[v];
    if (vertex.position_entry != kNoVertex) return;
    vertex.position_entry = static_cast<uint32_t>(out_.positions.size());
    out_.positions.push_back({v, positionOf(vertex), {}});
    if (out_.tells_moved) out_.moved.push_back({static_cast<float>(vertex.moved_m), 0});
  }
  void touchNormal(uint32_t v) {
    TerrainVertex& vertex = vertices_[v];
    if (vertex.normal_entry != kNoVertex) return;
    vertex.normal_entry = static_cast<uint32_t>(out_.normals.size());
    out_.normals.push_back({v, vertex.packed_normal, 0});
    if (!has_begun_) before_.push_back(vertex.packed_normal);
  }
  // A vertex whose arrays hold nothing yet.
  void addVertex(uint32_t v, const glm::vec2& parameter) {
    vertices_[v].packed_normal = kNoNormal;
    touchPosition(v);
    touchNormal(v);
    out_.parameters.push_back({v, parameter});
  }

  // All vertices are where the mesh begins.
  void beginDone() {
    has_begun_ = true;
    for (BlendPatch::Position& p : out_.positions) p.from = positionOf(vertices_[p.vertex]);
    for (size_t i = 0; i < out_.moved.size(); ++i) out_.moved[i].from = movedOf(out_.positions[i].vertex);
    for (BlendPatch::Normal& n : out_.normals) n.from = pack(n.vertex);
  }
  // All vertices are where the mesh ends. Leaves out normals that did not change, and vertices that are gone.
  void endDone() {
    for (BlendPatch::Position& p : out_.positions) {
      p.to = positionOf(vertices_[p.vertex]);
      vertices_[p.vertex].position_entry = kNoVertex;
    }
    for (size_t i = 0; i < out_.moved.size(); ++i) out_.moved[i].to = movedOf(out_.positions[i].vertex);
    size_t kept = 0;
    for (size_t i = 0; i < out_.normals.size(); ++i) {
      BlendPatch::Normal n = out_.normals[i];
      vertices_[n.vertex].normal_entry = kNoVertex;
      n.to = pack(n.vertex);
      const uint32_t before = i < before_.size() ? before_[i] : n.from;
      if (before != n.from || n.from != n.to) out_.normals[kept++] = n;
    }
    out_.normals.resize(kept);
    out_.vertex_count = vertices_.count();
  }

 private:
  static constexpr uint32_t kNoNormal = 0xffffffffu;  // packs of nothing

  glm::vec4 positionOf(const TerrainVertex& vertex) const {
    return {glm::vec3(vertex.position - origin_), static_cast<float>(vertex.height_m)};
  }
  float movedOf(uint32_t v) const { return static_cast<float>(vertices_[v].moved_m); }
  uint32_t pack(uint32_t v) {
    TerrainVertex& vertex = vertices_[v];
    return vertex.packed_normal = packNormal(vertex.unitNormal());
  }

  TerrainVertices& vertices_;
  glm::dvec3 origin_;
  BlendPatch& out_;
  std::vector<uint32_t> before_;  // normals that entries had before the mesh's beginning
  bool has_begun_ = false;
};

}  // namespace foreland::client
