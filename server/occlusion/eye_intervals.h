// Where a viewer's eye is expected to be, keyframe interval by keyframe interval, and how long that has been so. What
// is proved of the eyes of an interval holds until they are expected elsewhere. One owner.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "base/time.h"
#include "server/view/eye_sweep.h"

namespace foreland::server {

// Intervals are numbered: i lasts from i times a keyframe interval to i + 1 times that.
struct EyeOutlook {
  Duration interval;
  int64_t first = 0, last = 0;  // of those in which the keyframe is shown
  std::vector<EyeSweep> eyes;   // from the first interval on
  double error_m = 0;           // of a prediction; allowed for in `eyes`
};

// The eyes while a keyframe is shown, from `begin` to `end`, and in the intervals after that; up to `error_m`. Cost:
// some 100 poses.
EyeOutlook outlookOf(const ExpectedMotion& motion, Time begin, Time end, Duration interval, double error_m);

class EyeIntervals {
 public:
  static constexpr int64_t kAhead = 40;  // intervals, at most

  // The eyes of a keyframe, whose numbers increase. Of what was expected earlier all is kept that still holds the eyes.
  void expect(const EyeOutlook& outlook, uint32_t keyframe);
  // As if the eyes of all intervals had changed.
  void invalidate(uint32_t keyframe);

  int64_t first() const { return first_; }
  int64_t last() const { return last_; }
  int64_t end() const { return end_; }  // of those expected
  const EyeSweep& eyes(int64_t interval) const { return at(interval).eyes; }
  bool isPredicted() const { return is_predicted_; }         // by guess: not along a known path
  const EyeSweep& shownEyes() const { return shown_eyes_; }  // from first() to last(), with no more room than they need
  bool hasChanged() const { return has_changed_; }           // with the last keyframe, before end()
  // The first interval whose eyes have changed after a keyframe; end() or later if there is none.
  int64_t firstChangedAfter(uint32_t keyframe) const;

 private:
  struct Interval {
    int64_t number = -1;
    EyeSweep eyes;
    uint32_t changed_at = 0;
  };
  static constexpr size_t kSize = 64;
  const Interval& at(int64_t i) const { return ring_[static_cast<size_t>(i) % kSize]; }
  Interval& at(int64_t i) { return ring_[static_cast<size_t>(i) % kSize]; }
  void findFirstChanges(uint32_t keyframe);

  std::array<Interval, kSize> ring_;
  Duration interval_;
  int64_t first_ = 0, last_ = -1, end_ = 0;
  bool has_changed_ = false, is_predicted_ = false;
  EyeSweep shown_eyes_;
  uint32_t keyframe_ = 0;
  std::array<int64_t, kSize> first_changed_{};  // by age of the keyframe after which it has
};

}  // namespace foreland::server
