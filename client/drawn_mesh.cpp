#include "client/drawn_mesh.h"

#include <utility>

namespace foreland::client {

void DrawnMesh::add(uint32_t version, std::shared_ptr<const MeshPatch> patch) {
  waiting_.push_back({version, std::move(patch)});
}

void DrawnMesh::show(uint32_t version) { skipTo(version + 1); }

void DrawnMesh::skipTo(uint32_t version) {
  for (; !waiting_.empty() && waiting_.front().version < version; waiting_.pop_front()) apply(*waiting_.front().patch);
}

void DrawnMesh::apply(const MeshPatch& patch) {
  terrain_.apply(patch.terrain);
  objects_.apply(patch.objects);
  mesh_.from = patch.from;
  mesh_.to = patch.to;
  mesh_.earlier = patch.earlier;
  mesh_.origin = patch.origin;
  mesh_.from_nodes = patch.from_nodes;
  mesh_.to_nodes = patch.to_nodes;
  mesh_.object_parts = patch.object_parts;
}

}  // namespace foreland::client
