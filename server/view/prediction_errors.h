// How wrong the predictions of a viewer's pose have been of late. A keyframe is computed for a predicted pose, so its
// region is widened by what the predictor is likely to be off. One owner.
#pragma once

#include <array>
#include <cstddef>

#include "server/view/region.h"

namespace foreland::server {

class PredictionErrors {
 public:
  static constexpr size_t kMemory = 10;  // predictions
  static constexpr double kSafety = 1.5;

  // Notes a prediction, made for a keyframe `interval` after the one before it, once the true pose of its time is
  // known.
  void add(const proto::Pose& predicted, const proto::Pose& actual, Duration interval);

  // What the next prediction, for a keyframe after such an interval, may be off by: kSafety times the largest of the
  // last kMemory errors, of position and of orientation each; zero before the first. Errors of other intervals count in
  // proportion: those of long ones would widen the regions of short ones, and the other way round.
  Region estimate(Duration interval) const;

 private:
  struct Noted {
    Region error;
    Duration interval{1};
  };
  std::array<Noted, kMemory> errors_{};
  size_t count_ = 0;  // of all predictions noted so far
};

}  // namespace foreland::server
