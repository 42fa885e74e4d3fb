// Poses of a model (P section 5): the positions of its vertices at several dates, of one connectivity. Each pose
// belongs to an epoch (epochs.h) of the scene. At other epochs the model is mixed from the two poses next in time, by
// the dates; before the first pose and after the last it rests. At any scene time it is the blend of what it is at the
// epochs, as the ground is. So a vertex is always a mix of its poses with weights that add to 1; with a linear blend
// and a B-spline none is negative, and the vertex lies between them.
//
// What is stored and sent of a pose are *moves*: positions there minus those in the first pose, in quanta. Immutable;
// any thread; portable to WebAssembly.
#pragma once

#include <algorithm>
#include <cstdint>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

#include "base/result.h"
#include "proto/section/epochs.h"
#include "proto/section/surface_bounds.h"

namespace foreland::proto {

inline constexpr size_t kMaxPoses = 64;

class PoseBlend {
 public:
  // Of a model that has one pose and does not change.
  PoseBlend() = default;
  // `epochs` of the poses, ascending. An Error if they are one, more than kMaxPoses, out of order or none of the
  // scene's, or if the scene's blend may overshoot, which the bounds of a model do not allow for.
  static Result<PoseBlend> create(const Epochs& scene, std::span<const uint32_t> epochs);

  size_t poses() const { return poses_; }
  bool isStill() const { return poses_ <= 1; }
  // By pose but for the first, whose weight is what lacks to 1; empty if it is still.
  std::vector<double> weightsAt(const EpochWeights& epochs) const;
  bool operator==(const PoseBlend&) const = default;

 private:
  size_t poses_ = 1;
  std::vector<double> pose_at_;  // by epoch: the number of a pose, and how far it is towards the next
};

// The nodes of a model as its owner has them, by slot; a view.
struct ModelNodes {
  std::span<const SurfaceRecord> records;
  std::span<const glm::ivec3> moves{};  // of a node one after another, of each pose but the first
  size_t moves_each = 0;

  std::span<const glm::ivec3> movesOf(Slot slot) const { return moves.subspan(slot * moves_each, moves_each); }
};

// A move as near to this one as keeps the vertex within kMaxObjectQuanta: what is in files is not trusted.
inline glm::ivec3 moveWithin(const glm::ivec3& position, const glm::ivec3& move) {
  glm::ivec3 within;
  for (int axis = 0; axis < 3; ++axis) {
    const int64_t from = position[axis], most = kMaxObjectQuanta;
    within[axis] = static_cast<int32_t>(std::clamp(from + move[axis], -most, most) - from);
  }
  return within;
}

// The position, in quanta, of a vertex at a time when its poses have these weights (PoseBlend::weightsAt).
inline glm::dvec3 posed(const glm::ivec3& position, std::span<const glm::ivec3> moves,
                        std::span<const double> weights) {
  glm::dvec3 at(position);
  for (size_t k = 0; k < weights.size(); ++k) at += weights[k] * glm::dvec3(moves[k]);
  return at;
}

}  // namespace foreland::proto
