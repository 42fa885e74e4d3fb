// A surface of any topology: a base mesh, its rule of refinement, and the true position of every vertex, in one pose or
// several. Positions are whole quanta in the object's own frame, so that both ends compute the same ones and bounds are
// exact for what is drawn. Plain data; any thread.
#pragma once

#include <functional>
#include <glm/vec3.hpp>
#include <vector>

#include "base/result.h"
#include "proto/topology/mesh_topology.h"

namespace foreland::terrain {

inline constexpr int32_t kMaxQuanta = 1 << 30;  // of a coordinate, so that sums of two fit

// The same vertices elsewhere.
struct SurfacePose {
  std::vector<glm::ivec3> base, nodes;
};

struct TrueSurface {
  proto::MeshTopology topology;
  double quantum_m = 0.001;
  std::vector<glm::ivec3> base;      // topology.baseVertexCount() of them
  std::vector<glm::ivec3> nodes;     // by slot, topology.slotCount() of them; zeros in the padding
  std::vector<SurfacePose> poses{};  // but the first, which is above (proto/section/poses.h)

  const glm::ivec3& quanta(proto::NodeId v) const {
    return topology.isBase(v) ? base[proto::baseVertexOf(v)] : nodes[topology.slot(v)];
  }
  glm::dvec3 position(proto::NodeId v) const { return glm::dvec3(quanta(v)) * quantum_m; }
};

// The moves of base vertices, and of nodes by slot: of a vertex one after another.
std::vector<glm::ivec3> baseMoves(const TrueSurface& surface);
std::vector<glm::ivec3> nodeMoves(const TrueSurface& surface);

// The true position of a vertex in metres, given the middle of its endpoints' true positions (for a face's centre, of
// the face's corners).
using TruePosition = std::function<glm::dvec3(proto::NodeId, const glm::dvec3& middle)>;

// Calls `truePosition` for every vertex, coarse levels first, except those of the base mesh, whose positions are
// `corners`. Error, naming the first such vertex, for a position that is not finite or beyond kMaxQuanta quanta.
Result<TrueSurface> makeSurface(proto::MeshTopology topology, double quantum_m, const std::vector<glm::dvec3>& corners,
                                const TruePosition& truePosition);

// Calls visit(NodeId, Slot) for every node, coarse levels first.
template <class Visit>
void forEachNode(const proto::MeshTopology& topology, const Visit& visit) {
  for (proto::Slot slot = 0; slot < topology.slotCount(); ++slot)
    if (const proto::NodeId n = topology.node(slot); !topology.isBase(n)) visit(n, slot);
}

}  // namespace foreland::terrain
