#include "oracle/surface/surface_truth.h"

#include "proto/topology/mesh_triangles.h"

namespace foreland::oracle {

using proto::NodeId;
using proto::Slot;

SurfacePoint surfacePoint(const proto::FacePoint& at) {
  return {at.face, {static_cast<int32_t>(at.weights[1]), static_cast<int32_t>(at.weights[2])}};
}

SurfaceTruth truthOf(const terrain::TrueSurface& surface) {
  const proto::MeshTopology& mesh = surface.topology;
  SurfaceTruth truth;
  std::vector<uint32_t> number(mesh.slotCount());
  const auto add = [&](NodeId v) {
    truth.points.push_back(surfacePoint(mesh.facePoint(v)));
    truth.positions.push_back(surface.position(v));
  };
  for (uint32_t v = 0; v < mesh.baseVertexCount(); ++v) add(proto::baseVertexId(v));
  terrain::forEachNode(mesh, [&](NodeId n, Slot slot) {
    number[slot] = static_cast<uint32_t>(truth.points.size());
    add(n);
  });
  const auto vertex = [&](NodeId v) { return mesh.isBase(v) ? proto::baseVertexOf(v) : number[mesh.slot(v)]; };
  proto::forEachTriangle(
      mesh, [](NodeId) { return true; },
      [&](NodeId a, NodeId b, NodeId c) {
        truth.triangles.push_back({vertex(a), vertex(b), vertex(c)});
      });
  truth.is_closed = mesh.base().isClosed();
  return truth;
}

}  // namespace foreland::oracle
