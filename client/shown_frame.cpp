#include "client/shown_frame.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>
#include <utility>

#include "proto/space/jump.h"

namespace foreland::client {
namespace {

constexpr Duration kPoseMemory = Duration::milliseconds(10'000);

constexpr float kNone = std::numeric_limits<float>::infinity();

// By how much errors are larger on the screen than through the keyframe's lens; kNone if more is seen than through it.
float magnification(const proto::Lens& keyframe, const proto::Lens& shown) {
  if (shown == keyframe) return 1;
  constexpr double kRounding = 1e-9;
  const auto tanHalfWidth = [](const proto::Lens& l) { return l.tanHalfFov() * l.width_px / l.height_px; };
  const bool sees_more = shown.tanHalfFov() > keyframe.tanHalfFov() * (1 + kRounding) ||
                         tanHalfWidth(shown) > tanHalfWidth(keyframe) * (1 + kRounding);
  return sees_more ? kNone : static_cast<float>(shown.focalPx() / keyframe.focalPx());
}

// What the section of a keyframe guarantees for a camera.
float toleranceOf(const proto::KeyframeHeader& k, const FrameCamera& camera) {
  const bool is_covered = glm::distance(k.pose.eye, camera.pose.eye) + camera.eye_radius_m <= k.region_radius_m &&
                          proto::angleBetween(k.pose.orientation, camera.pose.orientation) <= k.region_angle_rad;
  return is_covered ? k.frameTolerance() * magnification(k.lens, camera.lens) : kNone;
}

// At weight 0 the newest section is not shown, and at 1 the oldest one, and its guarantee does not matter.
float toleranceOf(const Interval& interval, float weight, const FrameCamera& camera) {
  float tolerance_px = 0;
  if (weight < 1 || interval.earlier.count > 0) tolerance_px = toleranceOf(interval.from, camera);
  if (weight > 0) tolerance_px = std::max(tolerance_px, toleranceOf(interval.to, camera));
  for (uint32_t i = 0; i < interval.earlier.count; ++i) {
    const bool is_shown = i + 1 < interval.earlier.count || weight < 1;
    if (is_shown) tolerance_px = std::max(tolerance_px, toleranceOf(interval.earlier.headers[i], camera));
  }
  return tolerance_px;
}

}  // namespace

void CameraPath::add(Time now, const proto::Pose& pose) {
  if (poses_.empty() || now > poses_.back().time) {
    poses_.push_back({now, pose});
    if (std::exchange(jumps_next_, false)) jumps_.push_back(now);
  }
  std::erase_if(jumps_, [&](Time t) { return t < poses_.front().time; });
  if (poses_.front().time < now - kPoseMemory - kPoseMemory)
    poses_.erase(poses_.begin(), std::lower_bound(poses_.begin(), poses_.end(), now - kPoseMemory,
                                                  [](const proto::TimedPose& p, Time t) { return p.time < t; }));
}

bool CameraPath::isJump(const proto::TimedPose& before, const proto::TimedPose& after) const {
  return proto::isJump(before, after, 0) || std::binary_search(jumps_.begin(), jumps_.end(), after.time);
}

bool CameraPath::hasJustJumped() const { return poses_.size() > 1 && isJump(poses_[poses_.size() - 2], poses_.back()); }

bool CameraPath::hasJumpedSince(Time t) const {
  for (size_t i = poses_.size(); i-- > 1 && poses_[i].time > t;)
    if (isJump(poses_[i - 1], poses_[i])) return true;
  return false;
}

proto::Pose CameraPath::at(Time t) const {
  const auto after = std::lower_bound(poses_.begin(), poses_.end(), t,
                                      [](const proto::TimedPose& p, Time wanted) { return p.time < wanted; });
  if (after != poses_.begin() && after != poses_.end() && isJump(after[-1], *after))
    return after->time == t ? after->pose : after[-1].pose;
  return proto::poseAt(poses_, t);
}

ShownFrame showFrame(const Schedule::Shown& shown, const CameraPath& camera, const FrameCamera& now,
                     proto::Strategy strategy) {
  const Interval& interval = *shown.interval;
  const auto weight = static_cast<float>(shown.weight);
  const auto toleranceAt = [&](const proto::Pose& pose) {
    return toleranceOf(interval, weight, {pose, now.lens, now.eye_radius_m});
  };
  ShownFrame frame{.pose = strategy == proto::Strategy::kDelay ? camera.at(shown.shown_time) : now.pose};
  frame.tolerance_px = toleranceAt(frame.pose);
  frame.is_outside = std::isinf(frame.tolerance_px);
  if (strategy == proto::Strategy::kCurrent && !camera.hasJumpedSince(shown.shown_time))
    frame.tolerance_px = toleranceAt(camera.at(shown.shown_time));
  return frame;
}

}  // namespace foreland::client
