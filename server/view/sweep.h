// Where the camera will be while a keyframe's section is shown: from the keyframe before it to the one after. As a ball
// around the keyframe's eye and an angle around its orientation, which the refiner takes to keep tau in every frame
// (DESIGN section 3). Pure; any thread.
#pragma once

#include <functional>

#include "proto/space/pose.h"

namespace foreland::server {

struct Sweep {
  double region_radius_m = 0;
  double region_angle_rad = 0;
};

// The smallest ball and angle around `centre` that hold pose_at(t) for all t in [begin, end], from samples 20 ms apart
// or closer; motion between samples is covered by a twentieth of the longest step.
Sweep sweepOf(const proto::Pose& centre, const std::function<proto::Pose(Time)>& pose_at, Time begin, Time end);

// How wrong a predictor has been of late: the largest miss of its recent predictions, once the true poses are known.
// One owner.
class PredictionErrors {
 public:
  void add(const proto::Pose& predicted, const proto::Pose& actual);
  // Largest of the last kMemory misses, with half as much again; nothing before the first.
  Sweep estimate() const;

 private:
  static constexpr size_t kMemory = 10;
  Sweep errors_[kMemory];
  size_t count_ = 0;
};

}  // namespace foreland::server
