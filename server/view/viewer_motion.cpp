#include "server/view/viewer_motion.h"

#include <algorithm>
#include <glm/geometric.hpp>

#include "proto/space/jump.h"
#include "server/view/ground.h"

namespace foreland::server {

namespace {

// Poses are rounded on the wire, both ways.
constexpr Region kPoseRounding{0.01, 4e-4};

// A camera within this of its announced path follows it.
constexpr Region kMaxOffPath{50, 0.2};
constexpr double kMaxUnknownTurn_rad = 0.3;

constexpr size_t kMaxPredictions = 64;  // whose true poses have not arrived

}  // namespace

void ViewerMotion::add(const proto::TimedPose& pose) {
  if (foresight_ && (history_.empty() || pose.time > history_.newest().time)) foresight_->add(pose, false);
  history_.add(pose);
  while (!predictions_.empty() && predictions_.front().expected.time <= pose.time) {
    const Prediction& p = predictions_.front();
    errors_.add(p.expected.pose, history_.at(p.expected.time), p.interval);
    predictions_.pop_front();
  }
}

// Of the speed before something may hold after a jump, so the first keyframe is computed for a camera that goes on as
// fast, in any direction.
void ViewerMotion::jumpTo(const proto::TimedPose& pose) {
  if (!history_.empty() && history_.span() > Duration{}) {
    const Extrapolation motion = history_.extrapolate(proto::Predictor::kConstantVelocity);
    before_jump_ = {glm::length(motion.velocity), motion.turnRate()};
  }
  history_.restart(pose);
  if (foresight_) foresight_->add(pose, true);
  predictions_.clear();
  errors_ = {};
  region_share_ = {};
  if (path_ && !isPathFollowed(pose)) path_.reset();
}

bool ViewerMotion::isJump(const proto::TimedPose& pose, const terrain::Scene& scene) const {
  if (history_.empty() || pose.time <= history_.newest().time) return false;
  // The height is looked up for fast cameras only.
  if (!proto::isJump(history_.newest(), pose, 0)) return false;
  const auto height = [&](const proto::TimedPose& p) { return heightAboveGround(scene, p.pose.eye); };
  return proto::isJump(history_.newest(), pose, std::min(height(history_.newest()), height(pose)));
}

bool ViewerMotion::isPathFollowed(const proto::TimedPose& pose) const {
  const proto::Pose expected = path_->at(pose.time);
  const Region off{glm::distance(expected.eye, pose.pose.eye),
                   proto::angleBetween(expected.orientation, pose.pose.orientation)};
  return off.radius_m <= kMaxOffPath.radius_m && off.angle_rad <= kMaxOffPath.angle_rad;
}

bool ViewerMotion::isOnPath(const proto::ViewRequest& request) const {
  return request.strategy == proto::Strategy::kPredict && request.predictor == proto::Predictor::kKnownPath && path_;
}

ExpectedMotion ViewerMotion::expected(const proto::ViewRequest& request) const {
  if (isOnPath(request)) return ExpectedMotion(*path_);
  const bool predicts = request.strategy == proto::Strategy::kPredict;
  if (predicts && foresight_) return {history_, foresight_->extrapolate()};
  return {history_, predicts ? request.predictor : proto::Predictor::kConstantVelocity};
}

void ViewerMotion::notePrediction(const proto::TimedPose& expected, Duration interval) {
  if (expected.time <= history_.newest().time) {
    errors_.add(expected.pose, history_.at(expected.time), interval);
    return;
  }
  predictions_.push_back({expected, interval});
  if (predictions_.size() > kMaxPredictions) predictions_.pop_front();
}

double ViewerMotion::eyeError(Duration interval) const {
  return errors_.estimate(interval).radius_m + kPoseRounding.radius_m;
}

RegionParts ViewerMotion::regionAround(const proto::Pose& centre, const ExpectedMotion& motion, Time begin, Time end,
                                       Duration interval, Duration unknown) const {
  const Region more = unknownMotion(unknown);
  return {.motion = regionOf(centre, motion, begin, end),
          .error = errors_.estimate(interval),
          .rest = {more.radius_m + kPoseRounding.radius_m, more.angle_rad + kPoseRounding.angle_rad}};
}

Region ViewerMotion::unknownMotion(Duration time) const {
  if (isMotionKnown()) return {};
  const double s = time.toSeconds();
  return {before_jump_.radius_m * s, std::min(before_jump_.angle_rad * s, kMaxUnknownTurn_rad)};
}

}  // namespace foreland::server
