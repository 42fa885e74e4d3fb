#include "server/view/pose_history.h"

#include <algorithm>
#include <glm/geometric.hpp>

#include "proto/space/timed_poses.h"

namespace foreland::server {

namespace {

// The rotation `q` raised to a real power: the same axis, `factor` times the angle, by the shorter way round.
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
  if (poses_.size() == kCapacity) poses_.erase(poses_.begin());
  poses_.push_back(pose);
}

proto::Pose PoseHistory::at(Time t) const { return proto::poseAt(poses_, t); }

size_t PoseHistory::before(size_t i) const {
  size_t j = i;
  while (j > 0 && poses_[i].time - poses_[j].time < kBaseline) --j;
  return j;
}

proto::Pose PoseHistory::predict(proto::Predictor predictor, const std::optional<proto::Path>& path, Time t) const {
  const proto::TimedPose& last = poses_.back();
  if (predictor == proto::Predictor::kKnownPath && path) return path->at(t);
  const size_t n = poses_.size() - 1, m = before(n);
  if (predictor == proto::Predictor::kHold || t <= last.time || m == n) return last.pose;
  const double ahead = std::min(t - last.time, kHorizon).toSeconds();
  const double span = (last.time - poses_[m].time).toSeconds();
  const glm::dvec3 velocity = (last.pose.eye - poses_[m].pose.eye) / span;
  const glm::dquat turn = last.pose.orientation * glm::conjugate(poses_[m].pose.orientation);
  proto::Pose result;
  result.eye = last.pose.eye + velocity * ahead;
  result.orientation = glm::normalize(scaled(turn, ahead / span) * last.pose.orientation);
  const size_t k = before(m);
  if (predictor == proto::Predictor::kConstantAcceleration && k < m) {
    const double earlier_span = (poses_[m].time - poses_[k].time).toSeconds();
    const glm::dvec3 earlier = (poses_[m].pose.eye - poses_[k].pose.eye) / earlier_span;
    const glm::dvec3 acceleration = (velocity - earlier) / (0.5 * (span + earlier_span));
    // `velocity` is that of half a span ago.
    result.eye += acceleration * (0.5 * span * ahead + 0.5 * ahead * ahead);
  }
  return result;
}

}  // namespace foreland::server
