// What one viewer's server knows of hidden blocks from keyframe to keyframe.
//
// A block is hidden in a keyframe if that is proved for all eyes of the intervals in which the keyframe is shown
// (eye_intervals.h). Proofs are for spans of 16 or 8 intervals (path_spans.h): a block deep behind a ridge is tested
// every 16 keyframes, one near the ridge's edge every eight; half as many where the path is guessed. A block turns
// visible with the first keyframe that may show it, or up to seven earlier. One that is visible must be hidden for some
// intervals ahead, and by some margin, to turn hidden, lest it flicker; it is tried again when the span that shows
// it is past, and more and more seldom as long as it stays visible.
//
// Blocks are tested behind horizons (horizon.h); by rays (block_test.h), at most so many in a keyframe, in scenes that
// have no grid for these. Horizons take so many bytes at most: while they do, no block is proved to be hidden; and a
// keyframe that begins with more than half as many begins without any, which costs time, and no proof.
//
// One owner (a session), which sets the view before each keyframe. The results depend on nothing but what it is told.
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "proto/refine/metric/frustum.h"
#include "server/occlusion/block_test.h"
#include "server/occlusion/proofs/block_proofs.h"
#include "server/occlusion/proofs/eye_intervals.h"
#include "server/occlusion/proofs/path_spans.h"
#include "server/occlusion/scene_occlusion.h"

namespace foreland::server {

struct OcclusionStatistics {
  uint64_t tests = 0;     // of blocks for spans, since the start
  uint64_t rays = 0;      // where there is no grid
  uint64_t segments = 0;  // of horizons, built
};

class ViewerOcclusion final : public proto::BlockVisibility {
 public:
  struct Options {
    uint64_t rays = 120'000;          // in a keyframe, at most
    size_t horizon_bytes = 32 << 20;  // at any time; one test may exceed it by what it looks at
  };

  // Both must outlive it.
  ViewerOcclusion(const Hierarchy& hierarchy, const SceneOcclusion& scene)
      : ViewerOcclusion(hierarchy, scene, Options()) {}
  ViewerOcclusion(const Hierarchy& hierarchy, const SceneOcclusion& scene, const Options& options);
  ViewerOcclusion(const ViewerOcclusion&) = delete;
  ViewerOcclusion& operator=(const ViewerOcclusion&) = delete;

  // Before a keyframe. Without it the eyes are expected to stay in the keyframe's region.
  void expect(const PredictedEyePath& eye_path) { eye_path_ = eye_path; }

  void begin(const proto::View& view) override;
  bool isHidden(const proto::BlockId& block) override;
  uint32_t changes(const proto::BlockId& lowest, uint32_t known, uint32_t hidden) override;

  const OcclusionStatistics& statistics() const { return statistics_; }
  size_t bytes() const;  // in constant time

 private:
  enum class Towards : uint8_t { kVisible, kHidden };  // what a test is to find out for

  void expectNumbered(PredictedEyePath eye_path);

  enum class InView : uint8_t { kNot, kPartly, kWholly };
  InView inView(uint32_t scale, uint32_t i, uint32_t j) const;
  bool hides(PathSpan& span, const proto::BlockId& block, Towards towards);
  int64_t hiddenUntil(const proto::BlockId& block, BlockProof& proof, int64_t first, int64_t last, Towards towards);
  bool turnsHidden(const proto::BlockId& block, TileProofs& tile);
  bool staysHidden(const proto::BlockId& block, TileProofs& tile);
  bool review(const proto::BlockId& block, TileProofs& tile, bool was_hidden);

  const Hierarchy& hierarchy_;
  const SceneOcclusion& scene_;
  BlockTest test_;
  Options options_;
  std::optional<proto::View> view_;
  std::optional<proto::Frustum> frustum_;
  std::optional<PredictedEyePath> eye_path_;  // of the next keyframe
  int64_t origin_ = 0;                        // of the numbers of intervals here and in what follows
  EyeIntervals intervals_;
  PathSpans spans_;
  double tau_px_ = 0;  // that proofs allow for
  uint32_t keyframe_ = 0;
  uint64_t last_ray_ = 0;
  size_t horizon_bytes_ = 0;  // at most, of this keyframe
  BlockProofs proofs_;
  OcclusionStatistics statistics_;
};

}  // namespace foreland::server
