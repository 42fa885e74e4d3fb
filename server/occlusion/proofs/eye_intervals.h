// Where a viewer's eye is expected to be, keyframe interval by keyframe interval. One owner.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "base/time.h"
#include "server/view/eye_capsule.h"

namespace foreland::server {

// Intervals are numbered: i lasts from i times a keyframe interval to i + 1 times that.
struct PredictedEyePath {
  Duration interval;
  int64_t first = 0, last = 0;   // of those in which the keyframe is shown
  std::vector<EyeCapsule> eyes;  // from the first interval on
  double error_m = 0;            // of a prediction; allowed for in `eyes`
};

// The eyes in all intervals in which a keyframe is shown, from `begin` to `end`, however many these are, and in some
// after that; up to `error_m`. Cost: some 100 poses, at most kAhead capsules and half as many again.
PredictedEyePath eyePathOf(const ExpectedMotion& motion, Time begin, Time end, Duration interval, double error_m);

// By how much later predictions of an interval's eyes are likely to differ: a distance, and in errors of a prediction,
// for the interval shown and for each one ahead, squared.
struct PredictionRoom {
  double spare_m = 1.5, errors = 0.5, errors_ahead = 0.12;
};

class EyeIntervals {
 public:
  static constexpr int64_t kAhead = 40;  // intervals with eyes of their own while a keyframe is shown; after it, half
  static constexpr int64_t kMaxShown = 100;  // numbers for the time that a keyframe is shown

  void expect(PredictedEyePath eye_path) { eye_path_ = std::move(eye_path); }

  Duration interval() const { return eye_path_.interval; }
  int64_t first() const { return eye_path_.first; }
  int64_t last() const { return eye_path_.last; }
  int64_t end() const { return eye_path_.first + static_cast<int64_t>(eye_path_.eyes.size()); }  // of those expected
  // Of the expected ones among some intervals.
  std::span<const EyeCapsule> eyes(int64_t begin, int64_t end) const;
  bool isPredicted() const;      // by guess: not along a known path
  EyeCapsule shownEyes() const;  // from first() to last()
  // Metres of room for later predictions of an interval; for the rounding of the same eyes at least.
  double room(int64_t interval, const PredictionRoom& room) const;

 private:
  PredictedEyePath eye_path_{{}, 0, -1, {}, 0};
};

}  // namespace foreland::server
