// Says how a camera moves on, in place of the predictors that viewers choose from (proto::Predictor): how an experiment
// tries another one. One owner, a session's.
#pragma once

#include "proto/space/pose.h"
#include "server/view/extrapolation.h"

namespace foreland::server {

class Foresight {
 public:
  virtual ~Foresight() = default;
  // Takes the camera's next pose, newer than the one before. After a jump nothing known of the motion before holds.
  virtual void add(const proto::TimedPose& pose, bool has_jumped) = 0;
  // How the camera is expected to move on from the newest pose; at least one is known. Finite, the span above zero, the
  // rotation of unit length.
  virtual Extrapolation extrapolate() = 0;
};

}  // namespace foreland::server
