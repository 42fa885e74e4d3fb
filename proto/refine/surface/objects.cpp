#include "proto/refine/surface/objects.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <string>
#include <utility>

namespace foreland::proto {

namespace {

bool isPosition(const glm::ivec3& p) {
  const auto fine = [](int32_t v) { return v >= -kMaxObjectQuanta && v <= kMaxObjectQuanta; };
  return fine(p.x) && fine(p.y) && fine(p.z);
}

bool isMove(const glm::ivec3& from, const glm::ivec3& move) {
  for (int axis = 0; axis < 3; ++axis)
    if (std::abs(int64_t{from[axis]} + move[axis]) > kMaxObjectQuanta) return false;
  return true;
}

Status check(const ObjectModel& model, const MeshTopology& topology) {
  const auto refuse = [](const std::string& what) { return Error{ErrorCode::kMalformed, what}; };
  if (topology.slotCount() > ObjectSet::kMaxSlots)
    return refuse("more than " + std::to_string(ObjectSet::kMaxSlots) + " nodes");
  if (!(model.quantum_m > 0 && model.quantum_m <= 1e6))
    return refuse("a step that is not above 0 and at most 1,000,000 m");
  if (model.base.size() != topology.baseVertexCount())
    return refuse(std::to_string(model.base.size()) + " positions for " + std::to_string(topology.baseVertexCount()) +
                  " base vertices");
  if (model.atlas_side > AtlasLayout::kMaxPixels) return refuse("an image that is too large");
  for (size_t v = 0; v < model.base.size(); ++v)
    if (!isPosition(model.base[v])) return refuse("base vertex " + std::to_string(v) + " is too far away");
  const size_t moves = model.pose_epochs.empty() ? 0 : model.pose_epochs.size() - 1;
  if (model.base_moves.size() != moves * model.base.size())
    return refuse(std::to_string(model.base_moves.size()) + " moves of base vertices for " +
                  std::to_string(model.pose_epochs.size()) + " poses");
  for (size_t i = 0; i < model.base_moves.size(); ++i)
    if (!isMove(model.base[i / moves], model.base_moves[i]))
      return refuse("base vertex " + std::to_string(i / moves) + " moves too far away");
  return {};
}

}  // namespace

GroundRise::GroundRise(std::vector<int32_t> rises, const Epochs& epochs, const Frame& frame, const glm::dvec3& position)
    : quanta(std::move(rises)),
      quantum(FrameTransform(frame).upAt(position) * frame.height_quantum_m),
      range(epochs.range(quanta)) {}

glm::dvec3 GroundRise::at(const EpochWeights& weights) const {
  if (isStill()) return glm::dvec3(0);
  double risen = 0;
  for (uint32_t i = 0; i < weights.count; ++i) risen += weights.weight[i] * quanta[weights.epoch[i]];
  return risen * quantum;
}

View ObjectPlacement::toObject(const View& view) const {
  const glm::dquat back = glm::conjugate(orientation);
  View seen = view;
  seen.pose.eye = back * (view.pose.eye - position) / scale;
  seen.pose.orientation = back * view.pose.orientation;
  seen.region_radius_m = view.region_radius_m / scale;
  return seen;
}

View ObjectPlacement::toCarriedObject(const View& view) const {
  if (rise.isStill()) return toObject(view);
  const auto [lowest, highest] = rise.range;
  View seen = view;
  seen.pose.eye -= 0.5 * (lowest + highest) * rise.quantum;
  seen.region_radius_m += 0.5 * (highest - lowest) * glm::length(rise.quantum);
  return toObject(seen);
}

Result<ObjectSet> ObjectSet::create(std::vector<ObjectModel> models, std::vector<ObjectPlacement> placements,
                                    const Epochs& epochs) {
  const auto refuse = [](const std::string& what) { return Error{ErrorCode::kMalformed, "objects: " + what}; };
  if (models.size() > kMaxModels || placements.size() > kMaxObjects)
    return refuse("more than " + std::to_string(kMaxModels) + " models or " + std::to_string(kMaxObjects) + " objects");
  ObjectSet set;
  for (size_t i = 0; i < models.size(); ++i) {
    Result<MeshTopology> topology = MeshTopology::create(models[i].shape);
    if (!topology) return refuse("model " + std::to_string(i) + ": " + topology.error().message);
    if (Status s = check(models[i], *topology); !s.ok())
      return refuse("model " + std::to_string(i) + ": " + s.error().message);
    Result<PoseBlend> poses = PoseBlend::create(epochs, models[i].pose_epochs);
    if (!poses) return refuse("model " + std::to_string(i) + ": " + poses.error().message);
    set.poses_.push_back(std::move(*poses));
    set.topologies_.push_back(std::make_unique<const MeshTopology>(std::move(*topology)));
  }
  for (size_t i = 0; i < placements.size(); ++i) {
    const ObjectPlacement& p = placements[i];
    if (p.model >= models.size() || !isUsable(Pose{p.position, p.orientation}) || !(p.scale >= 1e-6 && p.scale <= 1e6))
      return refuse(
          "object " + std::to_string(i) +
          " is of no model, too far away, not turned by a rotation, or scaled by less than 1e-6 or more than 1e6");
    const MeshTopology& topology = *set.topologies_[p.model];
    set.domains_.push_back({.mesh = &topology,
                            .quantum_m = models[p.model].quantum_m,
                            .nearest_m = 0.1 / p.scale,
                            .is_closed = topology.base().isClosed()});
  }
  set.models_ = std::move(models);
  set.placements_ = std::move(placements);
  return set;
}

uint32_t fingerprintOf(size_t object, const CutDelta& delta) {
  const uint32_t odd = 2 * static_cast<uint32_t>(object) + 3;
  return odd * (fingerprint(delta.added) - fingerprint(delta.removed));
}

}  // namespace foreland::proto
