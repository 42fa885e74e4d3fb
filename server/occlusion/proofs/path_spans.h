// The eyes of several keyframe intervals at once, and what they see over the terrain: blocks are proved hidden for a
// span of intervals by one test.
//
// A span is for the eyes that are expected when it is made, with room for predictions that change. It is kept, and
// with it whatever was proved by it, for as long as the eyes that are expected later lie in that; then it is made anew.
// One owner.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "server/occlusion/horizon/horizon.h"
#include "server/occlusion/proofs/eye_intervals.h"

namespace foreland::server {

// Intervals begin to before end, which is a multiple of the span's length.
struct PathSpan {
  int64_t begin = 0, end = 0;
  bool is_made = false;
  uint32_t changed_at = 0;  // the last keyframe whose eyes were not those that it was made for; 0 if there is none
  EyeCapsule eyes;
  std::vector<EyeCapsule> earlier_eyes;  // for which it was made before, and what was proved may still hold
  std::shared_ptr<Horizon> horizon;      // null without a grid, and until it is asked for
};

class PathSpans {
 public:
  static constexpr size_t kLengths = 2;  // the longest first
  using Lengths = uint8_t;               // a set of them: bits

  // How many intervals the spans have, as logarithms, along known paths and along guessed ones, which are soon others;
  // and the room that there is for these to change.
  struct Shape {
    std::array<uint32_t, kLengths> known_log2, guess_log2;
    PredictionRoom room;
  };
  // For proofs that cost much: they are to last.
  static constexpr Shape kLasting{{4, 3}, {3, 2}, {}};
  // For proofs that cost little: the less eyes they are for, the more is hidden.
  static constexpr Shape kTight{{2, 1}, {1, 0}, {.spare_m = 0.2, .errors = 0.2, .errors_ahead = 0.05}};

  // Both must outlive it; `grid` may be null.
  PathSpans(const EyeIntervals& intervals, const HorizonGrid* grid, const Shape& shape)
      : intervals_(intervals), grid_(grid), shape_(shape) {}

  // After the intervals' eyes are those of a keyframe, whose numbers increase from 1.
  void revise(uint32_t keyframe);
  // As if all eyes had changed; horizons stay.
  void invalidate(uint32_t keyframe);
  void clear();

  // How many intervals the shortest spans have, and where that ends which holds an interval.
  int64_t shortest() const { return int64_t{1} << intervalsLog2(kLengths - 1); }
  int64_t shortestEnd(int64_t interval) const { return (interval & -shortest()) + shortest(); }
  // The last of some intervals up to which the shortest spans go at most.
  int64_t lastCoveredUpTo(int64_t interval) const;
  // The span of a length that holds an interval; null if not all of its eyes are expected, or if there is no room
  // for it beside those that are held. Valid until the next keyframe.
  PathSpan* at(size_t length, int64_t interval);
  // The intervals in which the keyframe is shown, and perhaps the next one; made anew once the eyes of these are
  // elsewhere. What is hidden behind it is so in this keyframe; in the next one it may be another. Valid until then.
  PathSpan& now();
  // With bins of this width.
  Horizon& horizonOf(PathSpan& span, double bin);

  // The first interval for which spans of some lengths no longer prove what they did in a keyframe; end() or later
  // if there is none.
  int64_t firstChangedAfter(uint32_t keyframe, Lengths lengths) const;
  // Increases with each keyframe in which firstChangedAfter() may be one of the intervals shown that it was not before.
  uint32_t revision() const { return revision_; }

  // Makes horizons of another grid from now on; it may be null if none is asked for. What was proved holds.
  void lookOver(const HorizonGrid* grid);
  // All horizons; those that are asked for again are made again.
  void dropHorizons();
  size_t bytes() const;

 private:
  static constexpr size_t kHeld = 32;  // of a length
  // There is room for all of eyePathOf(), or at least for what is expected of a keyframe that is shown in time.
  static_assert(EyeIntervals::kMaxShown + EyeIntervals::kAhead / 2 <= int64_t{kHeld - 2} << kLasting.guess_log2.back());
  static_assert(EyeIntervals::kAhead / 2 + 4 <= int64_t{kHeld - 2} << kTight.guess_log2.back());

  uint32_t intervalsLog2(size_t length) const {
    return (intervals_.isPredicted() ? shape_.guess_log2 : shape_.known_log2)[length];
  }

  struct Change {
    uint32_t keyframe;
    int64_t begin;
    Lengths lengths;
  };

  void revise(PathSpan& span, uint32_t keyframe);
  void collectChanges(uint32_t keyframe);
  EyeCapsule roomyEyes(const PathSpan& span) const;
  std::shared_ptr<Horizon> sightOf(const EyeCapsule& eyes) const;
  void dropHorizon(PathSpan& span);

  const EyeIntervals& intervals_;
  const HorizonGrid* grid_;
  const Shape shape_;
  std::array<std::array<PathSpan, kHeld>, kLengths> held_;
  PathSpan now_;
  std::vector<std::shared_ptr<Horizon>> spare_;  // their memory is used again
  std::vector<Change> changes_;                  // of the spans held
  uint32_t valid_since_ = 0, revision_ = 0;
  Duration interval_{};
  bool is_predicted_ = false;
  int64_t first_ = 0, last_ = 0;  // at the last revision
};

}  // namespace foreland::server
