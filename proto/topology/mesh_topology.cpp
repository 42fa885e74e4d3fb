#include "proto/topology/mesh_topology.h"

#include <string>
#include <utility>

namespace foreland::proto {

Result<MeshTopology> MeshTopology::create(MeshShape shape) {
  const auto refuse = [](const std::string& what) { return Error{ErrorCode::kMalformed, "mesh shape: " + what}; };
  if (shape.rule != MeshRule::kQuadrisection && shape.rule != MeshRule::kBisection)
    return refuse("unknown rule " + std::to_string(static_cast<int>(shape.rule)));
  if (shape.halvings < 1 || shape.halvings > kMaxHalvings)
    return refuse(std::to_string(shape.halvings) + " halvings of each edge; 1 to " + std::to_string(kMaxHalvings) +
                  " are supported");
  Result<BaseMesh> base = BaseMesh::create(shape.vertex_count, std::move(shape.faces));
  if (!base) return base.error();
  MeshTopology mesh;
  mesh.base_ = std::move(*base);
  mesh.rule_ = shape.rule;
  mesh.halvings_ = shape.halvings;
  mesh.max_level_ = mesh.isQuad() ? mesh.quad().maxLevel() : mesh.bisect().maxLevel();
  if (Status s = mesh.numberSlots(); !s.ok()) return s.error();
  return mesh;
}

Status MeshTopology::numberSlots() {
  Slot offset = 0;
  for (int level = 1; level <= max_level_; ++level) {
    level_offset_[level] = offset;
    offset += (slotsOfLevel(level) + kPageSlots - 1) / kPageSlots * kPageSlots;
    if (offset >= kMaxSlots)
      return Error{ErrorCode::kLimit, "mesh shape: more than 2^32 nodes; halve the edges of " +
                                          std::to_string(base_.faceCount()) + " faces fewer times than " +
                                          std::to_string(halvings_)};
  }
  level_offset_[max_level_ + 1] = offset;
  for (int width = 0, level = 1; width <= kSlotBits; ++width) {
    const Slot least = width == 0 ? 0 : Slot{1} << (width - 1);
    while (level < max_level_ && least >= level_offset_[level + 1]) ++level;
    level_hint_[width] = level;
  }
  return {};
}

FacePoint MeshTopology::facePoint(NodeId v) const {
  if (!isBaseVertexId(v)) return isQuad() ? quad().facePoint(patchPointOf(v)) : bisect().facePoint(patchPointOf(v));
  const uint32_t vertex = baseVertexOf(v), count = base_.vertexCount();
  return facePointIn(vertex < count ? BaseMesh::face(base_.leaving(vertex)) : vertex - count, v);
}

FacePoint MeshTopology::facePointIn(uint32_t face, NodeId v) const {
  if (!isBaseVertexId(v))
    return isQuad() ? quad().facePointIn(face, patchPointOf(v)) : bisect().facePointIn(face, patchPointOf(v));
  const uint32_t third = weightScale() / 3;
  if (v == baseVertexId(base_.vertexCount() + face)) return {face, {third, third, third}};
  FacePoint point{face, {0, 0, 0}};
  for (uint32_t i = 0; i < 3; ++i)
    if (base_.vertex(3 * face + i) == baseVertexOf(v)) point.weights[i] = weightScale();
  CHECK_EQ(point.weights[0] + point.weights[1] + point.weights[2], weightScale());
  return point;
}

}  // namespace foreland::proto
