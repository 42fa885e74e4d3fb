#include "server/view/expected_motion.h"

#include <glm/geometric.hpp>

namespace foreland::server {

proto::Pose ExpectedMotion::at(Time t) const {
  if (path_) return path_->at(t);
  if (t <= history_->newest().time) return history_->at(t);
  return told_ ? history_->predict(*told_, t) : history_->predict(predictor_, t);
}

std::optional<Time> ExpectedMotion::guessedUntil() const {
  if (path_) return std::nullopt;
  return history_->newest().time + PoseHistory::kHorizon;
}

std::optional<Time> ExpectedMotion::nextCorner(Time t) const {
  return path_ ? path_->nextPoseTime(t) : history_->nextCorner(t);
}

double ExpectedMotion::maxAcceleration(Time begin, Time end) const {
  if (path_) return path_->maxAcceleration(begin, end);
  const bool is_ahead = begin >= history_->newest().time && begin < history_->newest().time + PoseHistory::kHorizon;
  return is_ahead ? glm::length(extrapolation().acceleration) : 0;
}

double ExpectedMotion::turn(Time begin, Time end) const {
  if (!path_ && begin >= history_->newest().time && begin < history_->newest().time + PoseHistory::kHorizon)
    return extrapolation().turnRate() * (end - begin).toSeconds();
  return proto::angleBetween(at(begin).orientation, at(end).orientation);  // slerp: by the shorter way
}

}  // namespace foreland::server
