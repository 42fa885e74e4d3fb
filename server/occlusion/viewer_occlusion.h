// What one viewer's server knows of hidden blocks from keyframe to keyframe: which tests still hold, which must be made
// anew, and how many rays that may take.
//
// A block is called hidden from where the camera may be in this and, if it flies on as it does, in the next keyframes
// (EyeSweep), so that the result outlasts a few of them: until the region leaves the sweep. A visible block is tried
// again now and then, and must be hidden for several keyframes to be called so, lest it flicker. Once a keyframe's rays
// are used up, whatever is in doubt is visible. One owner (a session), which sets the view before each keyframe.
#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <memory>
#include <span>
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
    uint64_t rays = 120'000;        // in a keyframe, at most
    uint64_t first_rays = 400'000;  // in the first ones, and after a jump
  };

  // Both must outlive it.
  ViewerOcclusion(const Hierarchy& hierarchy, const SceneOcclusion& scene)
      : ViewerOcclusion(hierarchy, scene, Options()) {}
  ViewerOcclusion(const Hierarchy& hierarchy, const SceneOcclusion& scene, const Options& options)
      : hierarchy_(hierarchy), test_(hierarchy, *scene.occluder, scene.tops), options_(options) {}

  // How many keyframes ahead a sweep looks; the last is for the keyframe itself.
  static constexpr std::array<int, 8> kAhead{96, 48, 24, 12, 6, 3, 1, 0};
  using Sweeps = std::array<EyeSweep, kAhead.size()>;

  // Where the eye will be while a keyframe is shown, from `begin` to `end`, and afterwards, up to `error_m`. Cost: some
  // 130 poses.
  static Sweeps sweepsAhead(const ExpectedMotion& motion, Time begin, Time end, Duration interval, double error_m);

  // Before a keyframe. Without it the eyes of a keyframe are its region's ball, and nothing is known of those
  // afterwards.
  void expect(const Sweeps& sweeps) { expected_ = sweeps; }

  void begin(const proto::View& view) override;

  bool isHidden(const proto::BlockId& block) override;
  bool isStillHidden(const proto::BlockId& block, bool was_hidden) override;

  const OcclusionStatistics& statistics() const { return statistics_; }
  size_t bytes() const;

 private:
  // Eyes from which blocks were found to be hidden.
  struct Sweep {
    EyeSweep eyes;
    double tau_px;
    bool holds;          // for the view
    bool is_after_jump;  // of keyframes that found out about most of their blocks at once
  };
  // Of the blocks of a tile: the sweep from which it is hidden, 0 if none.
  struct Proofs {
    std::array<uint32_t, proto::HiddenBlocks::kTileBlocks> sweeps{};
    bool any = false;       // of its blocks has been hidden
    uint32_t keyframe = 0;  // when it was used last
  };
  bool meetsFrustum(const proto::BlockId& block) const;
  uint32_t& proofOf(const proto::BlockId& block);
  bool prove(const proto::BlockId& block, size_t first, size_t last);
  bool isAging(const proto::BlockId& block, uint32_t proof) const;
  bool hasHiddenInTile(const proto::BlockId& block);
  uint64_t raysLeft() const;

  const Hierarchy& hierarchy_;
  BlockTest test_;
  Options options_;
  std::optional<proto::View> view_;
  std::optional<proto::Frustum> frustum_;
  std::optional<Sweeps> expected_;  // of the next keyframe
  uint32_t keyframe_ = 0, settled_at_ = 0;
  uint64_t last_ray_ = 0;
  std::deque<Sweep> sweeps_;                     // of the last keyframes, kAhead.size() each
  uint32_t first_sweep_ = kAhead.size();         // number of the first
  std::unordered_map<uint64_t, Proofs> proofs_;  // by tile
  uint64_t last_tile_ = 0;
  Proofs* last_proofs_ = nullptr;
  OcclusionStatistics statistics_;
};

}  // namespace foreland::server
