// Who sees what: whether ground or objects, at full resolution, hide one point of a scene from another, exactly. Embree
// (box_tree.h) finds the blocks of ground and the groups of an object's triangles that a line may pass through; their
// triangles are tested in doubles (sight_line.h). So the answer does not depend on how large the scene is, and one tree
// answers for every scene time. It shares nothing with the proofs of what a viewer need not be sent (server/occlusion).
// The ground of a globe is looked for in the scene's own pages instead (triangle_tree.h), for its lattice is far larger
// than what is there of it.
//
// Immutable after creation; any thread may ask. Memory: about 9 bytes a sample of ground that is no globe's, and 20 a
// triangle of a model, however often that stands in the scene; bytes() tells.
#pragma once

#include <cstdint>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <limits>
#include <memory>
#include <optional>
#include <vector>

#include "base/result.h"
#include "base/time.h"
#include "server/section/hierarchy.h"
#include "server/sight/box_tree.h"
#include "server/sight/ground_surface.h"
#include "server/sight/object_surface.h"
#include "server/sight/triangle_tree.h"

namespace foreland::server {

struct SightOptions {
  uint64_t max_bytes = std::numeric_limits<int64_t>::max();  // of memory
};

// The ground and the objects at one scene time; of SightScene::at.
struct SightTime {
  proto::EpochWeights ground;
  std::vector<std::vector<double>> poses;  // of each model
  std::vector<glm::dvec3> positions;       // of each object, carried by the ground
};

// What hides a point.
struct SightHit {
  static constexpr int32_t kGround = -1;
  double share = 0;        // of the way
  glm::dvec3 position{0};  // scene frame
  int32_t object = kGround;
};

class SightScene {
 public:
  // kLimit if it would take more memory than it may. `hierarchy` must outlive it. O(samples + triangles), on the
  // calling thread alone.
  static Result<std::shared_ptr<const SightScene>> create(const Hierarchy& hierarchy, const SightOptions& options = {});

  // As it is at a scene time; without one at the last epoch. Of scenes that do not change every time is the same.
  SightTime at(std::optional<Time> scene_time) const;
  // Not of a globe.
  const GroundSurface& ground() const { return *ground_; }
  // Scene frame, of a point so far above the ground at a lattice position. Nothing beyond the data.
  std::optional<glm::dvec3> aboveGround(const glm::dvec2& lattice, double height_m, const SightTime& time) const;
  // The same above the zero surface, beyond the data too; nothing beyond the poles, or beyond a globe's lattice.
  std::optional<glm::dvec3> onZeroSurface(const glm::dvec2& lattice, double height_m) const;

  // The first point that hides `to` from `from`, or nothing; scene frame, finite, not farther than kMaxReach_m from its
  // origin. `refraction` as SightLine has it. A few microseconds; more over globes, and for lines that pass close
  // above much ground. `work` is raised by the number of blocks, groups and triangles that were looked at.
  static constexpr double kMaxReach_m = 2e7;
  std::optional<SightHit> firstHit(const glm::dvec3& from, const glm::dvec3& to, double refraction,
                                   const SightTime& time, uint64_t* work = nullptr) const;
  // Whether nothing hides it. Costs less.
  bool sees(const glm::dvec3& from, const glm::dvec3& to, double refraction, const SightTime& time,
            uint64_t* work = nullptr) const;

  const Hierarchy& hierarchy() const { return hierarchy_; }
  const proto::FrameTransform& transform() const { return hierarchy_.frame().transform(); }
  uint64_t bytes() const;

 private:
  SightScene(const Hierarchy& hierarchy, uint64_t tree_bytes);
  Status addObjects();
  Result<uint32_t> addPart(uint32_t model, double scale, const proto::ObjectPlacement* carried);
  struct Question;
  double pieces(double sag_m) const;

  const Hierarchy& hierarchy_;
  std::optional<GroundSurface> ground_;
  std::optional<TriangleTree> triangles_;                       // instead, of a globe
  std::vector<std::unique_ptr<const ObjectSurface>> surfaces_;  // of each model; null if nothing is of it
  BoxTree::Space space_;  // its margin is how far a bent path may be from the straight pieces that are cast
  BoxTree tree_;
};

}  // namespace foreland::server
