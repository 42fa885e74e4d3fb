#include "client/object_replica.h"

#include <algorithm>
#include <glm/geometric.hpp>
#include <utility>

#include "client/mesh/patch/pack_normal.h"

namespace foreland::client {

using proto::NodeId;
using proto::Slot;

ObjectReplica::ObjectReplica(const proto::ObjectSet& objects, size_t object)
    : objects_(&objects), object_(object), mesh_(objects, object) {}

bool ObjectReplica::step(proto::ObjectStream& stream, proto::RangeDecoder& coder, uint32_t& fingerprint) {
  delta_.added.clear();
  delta_.removed.clear();
  if (!stream.decode(object_, coder, delta_)) return false;
  for (Slot slot : delta_.removed) {
    const std::span<const glm::ivec3> moves = stream.moves(object_, slot);
    removed_[slot] = {stream.position(object_, slot), {moves.begin(), moves.end()}};
  }
  fingerprint += proto::fingerprintOf(object_, delta_);
  is_stale_ = is_stale_ || !delta_.added.empty() || !delta_.removed.empty();
  return true;
}

// Compares with the section that it saw last, so it does not matter how many steps lie between.
void ObjectReplica::blend(const MeshSpan& span, const proto::ObjectStream& stream) {
  const proto::ObjectPlacement& placement = objects_->placement(object_);
  const ObjectPatcher::Carried carried{placement.rise.at(span.ground[0]), placement.rise.at(span.ground[1])};
  const proto::PoseBlend& poses = objects_->posesOf(object_);
  PoseWeights weights{poses.weightsAt(span.ground[0]), poses.weightsAt(span.ground[1])};
  const bool is_same = weights == pose_weights_;
  pose_weights_ = std::move(weights);
  if (!std::exchange(is_stale_, false) && is_still_ && is_same) {
    has_changed_ = has_changed_ || carried != mesh_.carried();
    return mesh_.rest(carried);
  }
  proto::Section section = stream.section(object_);
  proto::diff(section_, section, delta_);
  section_ = std::move(section);
  const proto::View from = placement.toCarriedObject(span.from);
  const MorphTiming timing(span, from, span.motion.metres_per_s / placement.scale);
  morphs_.step(objects_->domain(object_).topology(), delta_, [&](Slot slot) {
    return !timing.isUniform() && facesAway(span.from, slot) ? 0 : intervals(timing, positions(stream), slot);
  });
  from_ = proto::apply(to_, morphs_.jumped());
  to_ = proto::apply(from_, morphs_.drawn());
  mesh_.step(positions(stream), morphs_, carried);
  is_still_ = morphs_.all().empty() && pose_weights_[0] == pose_weights_[1];
  has_changed_ = true;
  std::erase_if(removed_, [this](const auto& node) { return !mesh_.isDrawn(node.first); });
}

// The triangles that a node changes are taken to lie within two lengths of its edge.
double ObjectReplica::intervals(const MorphTiming& timing, const ObjectPositions& positions, Slot slot) const {
  if (timing.isUniform()) return timing.intervals({}, 0);
  const proto::MeshTopology& mesh = objects_->domain(object_).topology();
  const auto [a, b] = mesh.endpoints(mesh.node(slot));
  return timing.intervals(positions.at(mesh.node(slot), 1), 2 * glm::distance(positions.at(a, 1), positions.at(b, 1)));
}

// Whether the surface around the node faces away from the eye (`from`, in the scene's frame), by the normals that the
// last mesh ends with at the endpoints of the node's edge, with 30 degrees to spare for the triangles around it. Closed
// surfaces only, and none that moves in itself.
bool ObjectReplica::facesAway(const proto::View& from, Slot slot) const {
  constexpr double kSineToSpare = 0.5;
  const proto::SurfaceDomain& domain = objects_->domain(object_);
  if (!domain.is_closed || !objects_->posesOf(object_).isStill()) return false;
  for (NodeId end : domain.topology().endpoints(domain.topology().node(slot))) {
    glm::dvec3 position;
    uint32_t normal = 0;
    if (!mesh_.findEnd(end, position, normal)) return false;
    const glm::dvec3 to_eye = from.pose.eye - position;
    const double front = glm::dot(unpackNormal(normal), to_eye);
    if (front + from.region_radius_m > -kSineToSpare * glm::length(to_eye)) return false;
  }
  return true;
}

}  // namespace foreland::client
