// ViewerOcclusion holds, from keyframe to keyframe, what the server has proved of blocks that are hidden from one
// viewer.
//
// A block is hidden in a keyframe if the proof covers all eyes of the intervals in which the keyframe is shown
// (eye_intervals.h). One test proves a block hidden for a span of 16 or 8 intervals (path_spans.h), or of 8 or 4 where
// the path is guessed (decision 0017 weighs 4 and 2): a block deep behind a ridge gets the long spans, a block near the
// ridge's edge the short ones. A hidden block turns visible with the first keyframe that may show it, or up to seven
// keyframes earlier. To turn hidden, a visible block must be hidden for some intervals ahead, and by some margin, lest
// it flicker. A visible block is tested again when the span that shows it is past, and less often the longer it stays
// visible.
//
// Blocks are tested against horizons (horizon.h), or against rays (block_test.h) in scenes without a grid for horizons.
// Over globes the grid is one about the viewer's place (globe_grids.h): when the viewer gets another, horizons are made
// anew, and proofs go on, for they tell of the ground; without one nothing more is proved.
// Both are bounded by Options. While horizons take all of their bytes, no block is proved hidden. A keyframe that
// begins with more than half of these bytes drops all horizons first, which costs time, but no proof.
//
// One owner (a session) sets the view before each keyframe. The results depend on the calls alone.
#pragma once

#include <array>
#include <cstdint>
#include <glm/vec3.hpp>
#include <memory>
#include <optional>
#include <vector>

#include "proto/refine/metric/frustum.h"
#include "server/occlusion/block_test.h"
#include "server/occlusion/objects/viewer_objects.h"
#include "server/occlusion/proofs/block_proofs.h"
#include "server/occlusion/proofs/eye_intervals.h"
#include "server/occlusion/proofs/path_spans.h"
#include "server/occlusion/scene_occlusion.h"
#include "server/section/sender.h"

namespace foreland::server {

struct OcclusionStatistics {
  uint64_t tests = 0;     // Each test is of one block for one span.
  uint64_t rays = 0;      // Rays are cast only in scenes without a grid.
  uint64_t segments = 0;  // Horizons were built from so many segments.
  uint64_t queries = 0;   // Each query asks which solid of an object hides a target.

  // The processor time that these take on a usual machine (`foreland bench calibrate`, sim/compute_cost.h).
  Duration usualCost() const;
};

class ViewerOcclusion final : public proto::BlockVisibility, public ObjectVisibility {
 public:
  struct Options {
    // A keyframe casts at most this many rays (some 60 ms). With 20,000 a turn that nobody predicted ended more proofs
    // than could be renewed, and whole valleys became visible for seconds (decision 0017).
    uint64_t rays = 120'000;
    // All horizons take at most this many bytes; one test may exceed the limit by the segments that it builds. The
    // value is four times what the hungriest of 64 synthetic flights takes at 3840 x 2160 pixels.
    size_t horizon_bytes = 32 << 20;
  };

  // `hierarchy` and `scene` must outlive the object.
  ViewerOcclusion(const Hierarchy& hierarchy, const SceneOcclusion& scene)
      : ViewerOcclusion(hierarchy, scene, Options()) {}
  ViewerOcclusion(const Hierarchy& hierarchy, const SceneOcclusion& scene, const Options& options);
  ViewerOcclusion(const ViewerOcclusion&) = delete;
  ViewerOcclusion& operator=(const ViewerOcclusion&) = delete;

  // Says where the eyes will be. May be called before each begin(); without the call the eyes are expected to stay in
  // the keyframe's region.
  void expect(const PredictedEyePath& eye_path) { eye_path_ = eye_path; }

  // From the next keyframe on. kAll: what can be proved to be hidden is. kFading: nothing more is, and what is turns
  // visible part by part over kFadeKeyframes; whether anything in view is left says hidesAnything().
  enum class Effort : uint8_t { kAll, kFading };
  static constexpr uint32_t kFadeKeyframes = 10;
  void setEffort(Effort effort);
  // Whether a block in view was hidden in the last keyframe.
  bool hidesAnything() const { return hidden_in_view_ + (objects_ ? objects_->hiddenInView() : 0) > 0; }
  // A block that nothing is known of is not tested, but taken to be visible for a while, once a keyframe has spent so
  // long (OcclusionStatistics::usualCost) on tests.
  static constexpr Duration kUnlimited = Duration::seconds(1e6);
  void limitFirstTests(Duration limit) { first_tests_limit_ = limit; }
  // Forgets all proofs and horizons, and frees their memory: after keyframes without it.
  void forget();

  void begin(const proto::View& view) override;
  bool isHidden(const proto::BlockId& block) override;
  uint32_t changes(const proto::BlockId& lowest, uint32_t known, uint32_t hidden) override;
  // Of an object; after begin().
  bool isObjectHidden(size_t object, size_t nodes) override;

  const OcclusionStatistics& statistics() const { return statistics_; }
  size_t bytes() const;  // O(1)

 private:
  void chooseGrid();
  double binTangent() const;
  bool isByRays() const { return !scene_.grid && !scene_.globe; }
  void expectNumbered(PredictedEyePath eye_path);
  void clearSpans();
  void invalidateSpans();

  enum class InView : uint8_t { kNot, kPartly, kWholly };
  InView inView(uint32_t scale, uint32_t i, uint32_t j) const;
  struct Ball {
    uint64_t key = 0;
    glm::dvec3 middle{0};
    double radius_m = 0;
  };
  const Ball& globeBall(uint32_t scale, uint32_t i, uint32_t j) const;
  InView inView(const glm::dvec3& middle, double radius) const;
  bool hides(PathSpan& span, const proto::BlockId& block, Towards towards);
  bool isBehindObject(const proto::BlockId& block, const EyeCapsule& eyes);
  bool isBehindObject(uint32_t scale, uint32_t i, uint32_t j, const EyeCapsule& eyes);
  SpanProver prover();
  Horizon* horizonOf(PathSpan& span);
  bool isBehindRidge(const PathSpan& span, std::span<const glm::dvec3> points, Towards towards);
  template <class Test>
  bool testBehind(Horizon& horizon, const Test& test);
  Tolerance toleranceFor(Towards towards) const;
  void beginObjects();
  bool turnsHidden(const proto::BlockId& block, TileProofs& tile);
  bool staysHidden(const proto::BlockId& block, TileProofs& tile);
  bool review(const proto::BlockId& block, TileProofs& tile, bool was_hidden);
  bool hasFaded(const proto::BlockId& block) const;

  const Hierarchy& hierarchy_;
  const SceneOcclusion& scene_;
  BlockTest test_;
  Options options_;
  std::shared_ptr<const HorizonGrid> grid_;  // null: none, or none yet
  std::optional<proto::View> view_;
  std::optional<proto::Frustum> frustum_;
  std::optional<PredictedEyePath> eye_path_;  // expect() said this of the next keyframe.
  int64_t origin_ = 0;                        // Numbers of intervals count from this one in all members.
  EyeIntervals intervals_;
  PathSpans spans_;         // for blocks
  PathSpans object_spans_;  // for objects
  double tau_px_ = 0;       // Proofs hold for tolerances up to this one.
  uint32_t keyframe_ = 0;
  Effort effort_ = Effort::kAll;
  uint32_t fading_since_ = 0;  // the first keyframe of the fading
  uint64_t hidden_in_view_ = 0;
  Duration first_tests_limit_ = kUnlimited, cost_before_{};  // cost_before_: of all keyframes before this one
  uint64_t last_ray_ = 0;
  size_t horizon_bytes_ = 0;  // All horizons take at most so many bytes in this keyframe.
  BlockProofs proofs_;
  mutable std::vector<Ball> balls_;       // of squares of a globe that were looked at, by their names' hashes
  std::optional<ViewerObjects> objects_;  // The scene has some.
  uint32_t solid_hint_ = ObjectSolids::kNone;
  OcclusionStatistics statistics_;
};

}  // namespace foreland::server
