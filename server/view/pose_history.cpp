#include "server/view/pose_history.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "proto/space/timed_poses.h"

namespace foreland::server {

namespace {

// The rotation about the axis of `q` by `factor` times its angle, taken by the shorter way round.
glm::dquat scaled(glm::dquat q, double factor) {
  if (q.w < 0) q = -q;
  const glm::dvec3 axis(q.x, q.y, q.z);
  const double sine = glm::length(axis);
  if (sine < 1e-12) return {1, 0, 0, 0};
  const double half = std::atan2(sine, q.w) * factor;
  return {std::cos(half), axis * (std::sin(half) / sine)};
}

}  // namespace

void PoseHistory::add(const proto::TimedPose& pose) {
  if (!poses_.empty() && pose.time <= poses_.back().time) return;
  if (poses_.empty()) return restart(pose);
  const MotionRates rates = MotionRates::between(poses_.back(), pose);
  const double seconds = (pose.time - poses_.back().time).toSeconds();
  double_exponential_.add(rates, seconds);
  kalman_->add(pose.pose, rates, seconds);
  if (poses_.size() == kCapacity) poses_.erase(poses_.begin(), poses_.begin() + kCapacity / 2);
  poses_.push_back(pose);
}

void PoseHistory::restart(const proto::TimedPose& pose) {
  poses_.assign(1, pose);
  double_exponential_ = {};
  kalman_.emplace(pose.pose);
}

proto::Pose PoseHistory::at(Time t) const { return proto::poseAt(poses_, t); }

size_t PoseHistory::before(size_t i) const {
  size_t j = i;
  while (j > 0 && poses_[i].time - poses_[j].time < kBaseline) --j;
  return j;
}

Extrapolation PoseHistory::extrapolate(proto::Predictor predictor) const {
  const proto::TimedPose& last = poses_.back();
  const size_t n = poses_.size() - 1, m = before(n);
  Extrapolation result;
  if (predictor == proto::Predictor::kHold || m == n) return result;
  if (predictor == proto::Predictor::kDoubleExponential) return double_exponential_.extrapolate();
  if (predictor == proto::Predictor::kKalman) return kalman_->extrapolate();
  result.span_s = (last.time - poses_[m].time).toSeconds();
  result.velocity = (last.pose.eye - poses_[m].pose.eye) / result.span_s;
  result.rotation = last.pose.orientation * glm::conjugate(poses_[m].pose.orientation);
  const size_t k = before(m);
  if (predictor == proto::Predictor::kConstantAcceleration && k < m) {
    const double earlier_span = (poses_[m].time - poses_[k].time).toSeconds();
    const glm::dvec3 earlier = (poses_[m].pose.eye - poses_[k].pose.eye) / earlier_span;
    result.acceleration = (result.velocity - earlier) / (0.5 * (result.span_s + earlier_span));
  }
  return result;
}

proto::Pose PoseHistory::predict(proto::Predictor predictor, Time t) const {
  const proto::TimedPose& last = poses_.back();
  if (predictor == proto::Predictor::kHold || poses_.size() == 1 || t <= last.time) return last.pose;
  return predict(extrapolate(predictor), t);
}

proto::Pose PoseHistory::predict(const Extrapolation& motion, Time t) const {
  const proto::TimedPose& last = poses_.back();
  if (poses_.size() == 1 || t <= last.time) return last.pose;
  const double ahead = std::min(t - last.time, kHorizon).toSeconds(), span = motion.span_s;
  proto::Pose result;
  // `velocity` is that of half a span ago.
  result.eye = last.pose.eye + motion.velocity * ahead;
  result.eye += motion.acceleration * (0.5 * span * ahead + 0.5 * ahead * ahead);
  result.orientation = glm::normalize(scaled(motion.rotation, ahead / span) * last.pose.orientation);
  return result;
}

std::optional<Time> PoseHistory::nextCorner(Time t) const {
  const auto after =
      std::upper_bound(poses_.begin(), poses_.end(), t, [](Time v, const proto::TimedPose& p) { return v < p.time; });
  if (after != poses_.end()) return after->time;
  const Time horizon = newest().time + kHorizon;
  return t < horizon ? std::optional(horizon) : std::nullopt;
}

}  // namespace foreland::server
