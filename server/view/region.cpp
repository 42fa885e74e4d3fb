#include "server/view/region.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>

namespace foreland::server {

namespace {

constexpr double kHalfTurn = std::numbers::pi;
constexpr double kNearlyHalfTurn_rad = kHalfTurn - 1e-6;  // the shorter way round is still certain

// Grows from pose to pose along a motion.
class Growth {
 public:
  Growth(const proto::Pose& centre, const ExpectedMotion& motion, Time begin)
      : centre_(centre), motion_(motion), time_(begin), pose_(motion.at(begin)) {
    include(pose_);
  }

  // Includes the poses from the last one to that at `end`, cut at the motion's corners.
  void advanceTo(Time end) {
    for (auto corner = motion_.nextCorner(time_); corner && *corner < end; corner = motion_.nextCorner(time_))
      includePiece(*corner);
    includePiece(end);
  }

  const proto::Pose& pose() const { return pose_; }
  // Of the poses at which the motion was cut, and for orientations of all between.
  const Region& region() const { return region_; }
  // How far the eye may leave the chords between the cuts.
  double maxBend() const { return max_bend_m_; }

 private:
  void include(const proto::Pose& pose) {
    region_.radius_m = std::max(region_.radius_m, glm::distance(pose.eye, centre_.eye));
    region_.angle_rad = std::max(region_.angle_rad, proto::angleBetween(pose.orientation, centre_.orientation));
  }

  // Eyes: on a chord the distance from the centre is convex, hence largest at an end. A curve leaves its chord by at
  // most h^2 / 8 times its largest second derivative (the error of linear interpolation).
  //
  // Orientations turn about one axis, so as unit quaternions they lie on a great circle, and their product with the
  // centre is A cos(s - s0), s half the angle. Where that is positive it is concave: over a piece of less than half a
  // turn it is least, and the angle to the centre largest, at an end, unless it changes its sign; then half a turn
  // away is passed.
  void includePiece(Time end) {
    const double h = (end - time_).toSeconds();
    const proto::Pose next = motion_.at(end);
    max_bend_m_ = std::max(max_bend_m_, h * h / 8 * motion_.maxAcceleration(time_, end));
    const double sense = glm::dot(pose_.orientation, next.orientation) < 0 ? -1 : 1;
    const double before = glm::dot(centre_.orientation, pose_.orientation);
    const double after = glm::dot(centre_.orientation, next.orientation) * sense;
    if (before * after <= 0 || motion_.turn(time_, end) > kNearlyHalfTurn_rad) region_.angle_rad = kHalfTurn;
    include(next);
    time_ = end;
    pose_ = next;
  }

  const proto::Pose& centre_;
  const ExpectedMotion& motion_;
  Time time_;
  proto::Pose pose_;
  Region region_;
  double max_bend_m_ = 0;
};

}  // namespace

Region regionOf(const proto::Pose& centre, const ExpectedMotion& motion, Time begin, Time end) {
  constexpr int64_t kStep_us = 20'000, kMaxSteps = 200;
  // The bound needs the bend alone, which is far less than this where a path is smooth. This much was always added;
  // without it the regions on the wire, and with them recorded streams, would change to save half a percent.
  constexpr double kAllowance = 0.05;
  const int64_t steps = std::clamp<int64_t>(((end - begin).us + kStep_us - 1) / kStep_us, 1, kMaxSteps);
  Growth growth(centre, motion, begin);
  Region longest;  // step
  for (int64_t i = 1; i <= steps; ++i) {
    const proto::Pose last = growth.pose();
    growth.advanceTo(timeBetween(begin, end, i, steps));
    longest.radius_m = std::max(longest.radius_m, glm::distance(growth.pose().eye, last.eye));
    longest.angle_rad = std::max(longest.angle_rad, proto::angleBetween(growth.pose().orientation, last.orientation));
  }
  return {growth.region().radius_m + std::max(growth.maxBend(), kAllowance * longest.radius_m),
          growth.region().angle_rad + kAllowance * longest.angle_rad};
}

}  // namespace foreland::server
