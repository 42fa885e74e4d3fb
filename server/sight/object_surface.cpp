#include "server/sight/object_surface.h"

#include "base/check.h"
#include "proto/topology/mesh_triangles.h"

namespace foreland::server {

namespace {

const proto::MeshTopology& topologyOf(const SceneObjects& objects, uint32_t model) {
  const auto& placements = objects.set.placements();
  const auto at = std::find_if(placements.begin(), placements.end(), [&](const auto& p) { return p.model == model; });
  CHECK_TRUE(at != placements.end());
  return objects.set.domain(static_cast<size_t>(at - placements.begin())).topology();
}

}  // namespace

ObjectSurface::ObjectSurface(const SceneObjects& objects, uint32_t model)
    : model_(objects.set.models()[model]), nodes_(objects.nodes[model]) {
  const proto::MeshTopology& mesh = topologyOf(objects, model);
  base_ = mesh.baseVertexCount();
  const auto number = [&](proto::NodeId v) {
    return mesh.isBase(v) ? proto::baseVertexOf(v) : mesh.baseVertexCount() + mesh.slot(v);
  };
  proto::forEachTriangle(
      mesh, [](proto::NodeId) { return true; },
      [&](proto::NodeId a, proto::NodeId b, proto::NodeId c) {
        for (proto::NodeId v : {a, b, c}) corners_.push_back(number(v));
      });
  corners_.shrink_to_fit();
  for (uint32_t group = 0; group < groups(); ++group) {
    const Box box = boundsOf(group);
    for (int axis = 0; axis < 3; ++axis) reach_m_ = std::max({reach_m_, -box.low[axis], box.high[axis]});
  }
}

std::span<const glm::ivec3> ObjectSurface::movesOf(uint32_t vertex) const {
  if (vertex >= base_) return nodes_.movesOf(vertex - base_);
  return std::span(model_.base_moves).subspan(vertex * nodes_.moves_each, nodes_.moves_each);
}

Box ObjectSurface::boundsOf(uint32_t group) const {
  Box box;
  const uint32_t end = std::min(triangles(), (group + 1) * kGroup);
  for (uint32_t corner = 3 * group * kGroup; corner < 3 * end; ++corner) {
    const uint32_t v = corners_[corner];
    const glm::dvec3 first(quantaOf(v));
    box.add(first * model_.quantum_m);
    if (nodes_.moves_each == 0) continue;
    for (const glm::ivec3& move : movesOf(v)) box.add((first + glm::dvec3(move)) * model_.quantum_m);
  }
  return box;
}

}  // namespace foreland::server
