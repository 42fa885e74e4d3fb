// What one viewer's server knows of hidden blocks from keyframe to keyframe: which tests still hold, which must be made
// anew, and how many rays that may take.
//
// A block is called hidden from a ball that is larger than the keyframe's region, so that the result outlasts a few
// keyframes: until the region leaves the ball. A visible block is tried again now and then, and must be hidden from
// well beyond the region to be called so, lest it flicker. Once a keyframe's rays are used up, whatever is in doubt is
// visible. One owner (a session), which sets the view before each keyframe.
#pragma once

#include <cstdint>
#include <memory>
#include <unordered_map>

#include "proto/refine/frustum.h"
#include "server/occlusion/block_test.h"

namespace foreland::server {

// What all viewers of a scene share.
struct SceneOcclusion {
  std::shared_ptr<const Occluder> occluder;
  BlockTops tops;

  // As Occluder::create.
  static Result<std::shared_ptr<const SceneOcclusion>> create(const Hierarchy& hierarchy);
  size_t bytes() const { return occluder->bytes() + tops.bytes(); }
};

struct OcclusionStatistics {
  uint64_t rays = 0, tests = 0;  // since the start
  uint64_t reviews = 0;          // of known blocks
};

class ViewerOcclusion final : public proto::BlockVisibility {
 public:
  struct Options {
    uint64_t rays = 20000;          // in a keyframe
    uint64_t first_rays = 200'000;  // in the first one, and after a jump
  };

  // Both must outlive it.
  ViewerOcclusion(const Hierarchy& hierarchy, const SceneOcclusion& scene)
      : ViewerOcclusion(hierarchy, scene, Options()) {}
  ViewerOcclusion(const Hierarchy& hierarchy, const SceneOcclusion& scene, const Options& options)
      : hierarchy_(hierarchy), test_(hierarchy, *scene.occluder, scene.tops), options_(options) {}

  void begin(const proto::View& view) override;

  bool isHidden(const proto::BlockId& block) override;
  bool isStillHidden(const proto::BlockId& block, bool was_hidden) override;

  const OcclusionStatistics& statistics() const { return statistics_; }
  size_t bytes() const;

 private:
  // A ball of eyes from which a block is hidden.
  struct Proof {
    glm::dvec3 eye;
    double radius_m, tau_px;
    uint32_t keyframe;  // when it was used last
  };

  bool meetsFrustum(const proto::BlockId& block) const;
  bool holds(const Proof& proof) const;
  bool prove(const proto::BlockId& block, std::initializer_list<double> spare_m);
  uint64_t raysLeft() const;

  const Hierarchy& hierarchy_;
  BlockTest test_;
  Options options_;
  std::optional<proto::View> view_;
  std::optional<proto::Frustum> frustum_;
  double spare_m_ = 0;  // the eye's way in a keyframe, about
  uint32_t keyframe_ = 0;
  uint64_t last_ray_ = 0;
  std::unordered_map<uint64_t, Proof> proofs_;
  OcclusionStatistics statistics_;
};

}  // namespace foreland::server
