#include "client/mesh/objects/object_positions.h"

#include <glm/geometric.hpp>

#include "proto/topology/mesh_triangles.h"

namespace foreland::client {

using proto::NodeId;
using proto::Slot;

glm::dvec3 ObjectPositions::at(NodeId v, size_t end) const {
  const proto::MeshTopology& mesh = objects.domain(object).topology();
  const proto::ObjectModel& model = objects.modelOf(object);
  const size_t moves_each = objects.posesOf(object).poses() - 1;
  if (mesh.isBase(v)) {
    const uint32_t base = proto::baseVertexOf(v);
    const auto moves = std::span(model.base_moves).subspan(base * moves_each, moves_each);
    return proto::posed(model.base[base], moves, weights[end]) * model.quantum_m;
  }
  const Slot slot = mesh.slot(v);
  if (const auto it = removed.find(slot); it != removed.end())
    return proto::posed(it->second.position, it->second.moves, weights[end]) * model.quantum_m;
  const glm::ivec3& position = stream.position(object, slot);
  if (moves_each == 0) return glm::dvec3(position) * model.quantum_m;
  return proto::posed(position, stream.moves(object, slot), weights[end]) * model.quantum_m;
}

// Edges are no longer than the model's box in all poses, twice over for what nodes add to it.
FaceNormal objectFaceNormal(const proto::ObjectModel& model) {
  glm::dvec3 low(0), high(0);
  const auto include = [&](const glm::dvec3& p) { low = glm::min(low, p), high = glm::max(high, p); };
  for (const glm::ivec3& p : model.base) include(glm::dvec3(p));
  for (size_t i = 0; i < model.base_moves.size(); ++i)
    include(glm::dvec3(model.base[i / (model.base_moves.size() / model.base.size())]) +
            glm::dvec3(model.base_moves[i]));
  return FaceNormal(2 * glm::distance(low, high) * model.quantum_m);
}

}  // namespace foreland::client
