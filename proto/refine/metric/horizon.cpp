#include "proto/refine/metric/horizon.h"

#include <glm/geometric.hpp>
#include <limits>

namespace foreland::proto {

namespace {

// tan of the angle whose sine is given, which is below 1.
double slopeOf(double sine) { return sine / std::sqrt((1 - sine) * (1 + sine)); }

}  // namespace

Horizon::Horizon(const Frame& frame, double ceiling_m, const View& view, const Frustum& frustum) {
  stretch_ = frame.semi_major_m / frame.semiMinor();
  const glm::dvec3 eye(view.pose.eye.x, view.pose.eye.y, view.pose.eye.z * stretch_);
  distance_ = glm::length(eye);
  // A metre is more than rounding of the mesh's and of the lattice's positions.
  const double floor = frame.semi_major_m - stretch_ * (std::max(0.0, -frame.floor()) + 1),
               ball = floor - stretch_ * view.region_radius_m;
  if (!(ball > 0) || !(ball < distance_ * (1 - 1e-9))) {
    slack_if_useless_m_ = std::max(0.0, ball - distance_ * (1 - 1e-9)) / (2 * stretch_);
    return;
  }
  ball_ = ball;
  axis_ = eye * (-1 / distance_);
  rows_[0] = {frustum.right().x, frustum.up().x, frustum.forward().x};
  rows_[1] = {frustum.right().y, frustum.up().y, frustum.forward().y};
  rows_[2] = stretch_ * glm::dvec3(frustum.right().z, frustum.up().z, frustum.forward().z);
  sin_ = ball_ / distance_;
  cos_ = std::sqrt((1 - sin_) * (1 + sin_));
  tangent_ = (distance_ - ball_) * (1 + sin_);
  slope_ = slopeOf(sin_);
  widest_ = 0.5 * (distance_ - ball_);
  widest_slope_ = slopeOf((ball_ + widest_) / distance_);
  limitDirections(floor, frame.semi_major_m + stretch_ * (std::max(0.0, ceiling_m) + 1),
                  stretch_ * view.region_radius_m);
}

void Horizon::limitDirections(double floor, double top, double region) {
  const double nearest = distance_ - region, farthest = distance_ + region;
  per_apart_ = per_apart_seen_ = widest_apart_ = std::numeric_limits<double>::max();
  if (!(top < 2 * floor)) return;
  if (!(nearest > floor * (1 + 1e-9))) {
    widest_apart_ = std::max(0.0, floor * (1 + 1e-9) - nearest) / 2;
    return;
  }
  const double cos_eye = floor / farthest, cos_top = floor / top,
               cosine = cos_eye * cos_top - std::sqrt((1 - cos_eye * cos_eye) * (1 - cos_top * cos_top));
  apart_ = std::sqrt(2 - 2 * cosine) + region / nearest;
  per_radius_ = stretch_ / floor;
  widest_apart_ = 0.5 * std::min(nearest - floor, floor - region);  // without a ball nothing is hidden
  const double least = nearest - widest_apart_, turn = 1 / least + region / (least * least);
  const auto rise = [&](double distance) {
    return floor / (distance * std::sqrt((distance - floor) * (distance + floor)));
  };
  per_apart_ = 1 / (turn + rise(farthest));
  per_apart_seen_ = 1 / (turn + rise(farthest - widest_apart_));
}

}  // namespace foreland::proto
