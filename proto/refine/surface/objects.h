// The objects of a scene: surfaces that stand on its terrain. A model is what is known of a surface before any node; it
// may stand at many positions. Both ends make the same set of what the welcome says, and move each object from section
// to section with the adapter that moves the terrain: the view is taken to the object's frame. Immutable; any thread;
// portable to WebAssembly.
#pragma once

#include <glm/gtc/quaternion.hpp>
#include <memory>
#include <span>
#include <vector>

#include "base/result.h"
#include "proto/refine/surface/surface_domain.h"
#include "proto/section/epochs.h"
#include "proto/section/poses.h"
#include "proto/section/section.h"
#include "proto/space/frame.h"
#include "proto/topology/atlas_layout.h"

namespace foreland::proto {

struct ObjectModel {
  MeshShape shape;
  double quantum_m = 0.001;
  std::vector<glm::ivec3> base;  // quanta; of all vertices that precede the nodes
  uint32_t atlas_side = 0;       // of the image of its colours (atlas_layout.h); 0: there is none
  // The epochs of its poses (section/poses.h); none: it has one and does not change. The moves of `base`: of a vertex
  // one after another.
  std::vector<uint32_t> pose_epochs{};
  std::vector<glm::ivec3> base_moves{};
  bool operator==(const ObjectModel&) const = default;
};

// How the ground carries what stands on it, in a scene that changes in time: straight up and down with the ground at
// one point.
struct GroundRise {
  std::vector<int32_t> quanta;    // by epoch, since the first one; empty: it never moves
  glm::dvec3 quantum{0};          // scene frame, metres
  std::array<double, 2> range{};  // quanta, at all scene times (Epochs::range)

  GroundRise() = default;
  // Of what stands at `position`, scene frame.
  GroundRise(std::vector<int32_t> quanta, const Epochs& epochs, const Frame& frame, const glm::dvec3& position);
  bool isStill() const { return quanta.empty(); }
  // Where it has been carried to at a scene time, scene frame, metres.
  glm::dvec3 at(const EpochWeights& weights) const;
  bool operator==(const GroundRise&) const = default;
};

// From the model's frame to the scene's: scaled, turned, moved.
struct ObjectPlacement {
  uint32_t model = 0;
  glm::dvec3 position{0};              // scene frame, metres
  glm::dquat orientation{1, 0, 0, 0};  // unit
  double scale = 1;
  GroundRise rise{};

  // As it stands at the first epoch.
  glm::dvec3 toScene(const glm::dvec3& p) const { return position + orientation * (p * scale); }
  // Pixels stay what they are. The object stands as at the first epoch.
  View toObject(const View& view) const;
  // The same, with a region that holds the view wherever the ground carries the object. O(epochs).
  View toCarriedObject(const View& view) const;
};

class ObjectSet {
 public:
  static constexpr size_t kMaxModels = 1024, kMaxObjects = 4096;
  static constexpr Slot kMaxSlots = 1u << 26;  // of one model

  ObjectSet() = default;
  // Refuses shapes that MeshTopology refuses, poses that PoseBlend refuses for a scene of these epochs, positions and
  // placements that are out of bounds or do not fit: by the number of the model or object.
  static Result<ObjectSet> create(std::vector<ObjectModel> models, std::vector<ObjectPlacement> placements,
                                  const Epochs& epochs = {});

  size_t size() const { return placements_.size(); }
  const std::vector<ObjectModel>& models() const { return models_; }
  const std::vector<ObjectPlacement>& placements() const { return placements_; }
  const ObjectPlacement& placement(size_t object) const { return placements_[object]; }
  const ObjectModel& modelOf(size_t object) const { return models_[placements_[object].model]; }
  const SurfaceDomain& domain(size_t object) const { return domains_[object]; }
  const PoseBlend& posesOf(size_t object) const { return posesOfModel(placements_[object].model); }
  const PoseBlend& posesOfModel(size_t model) const { return poses_[model]; }

 private:
  std::vector<ObjectModel> models_;
  std::vector<std::unique_ptr<const MeshTopology>> topologies_;  // behind pointers, for domains refer to them
  std::vector<PoseBlend> poses_;                                 // of each model
  std::vector<ObjectPlacement> placements_;
  std::vector<SurfaceDomain> domains_;
};

// What a change of an object's section adds to the fingerprint of all.
uint32_t fingerprintOf(size_t object, const CutDelta& delta);

}  // namespace foreland::proto
