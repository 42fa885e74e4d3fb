// The refinement test: does a node's support meet the view, and would leaving the node out be seen by more than tau pixels?
//
// For a point at view coordinates p (depth z, distance d, horizontal distance h from the eye) an error e moves its image by at
// most  f e d / z^2  if the error may point anywhere, and at most  f e h / z^2  if it is vertical (the image displacement is the
// screen part of e x p), with f the focal length in pixels. Over the node's sphere (centre c, radius r) every visible point has
// z >= z_min = max(z(c) - r, (d(c) - r) cos(corner)), h <= h(c) + r, d/z <= 1/cos(corner), so the test is
//
//   f e min((h + r) / z_min, 1/cos(corner)) > tau z_min        (vertical; the minimum is 1/cos(corner) otherwise)
//
// Both this and the frustum test only grow with the sphere and the error. A parent's sphere holds its children's with
// 5e-6 m to spare (terrain/bounds) and its error is no smaller, while rounding here stays below 1e-7 m for
// eyes within 10^8 m; so if a node passes, its parents do, in floating point too: the nodes that pass are closed under parents.
// Immutable; any thread.
#pragma once

#include <algorithm>
#include <cmath>
#include <glm/vec3.hpp>

#include "proto/pose.h"

namespace foreland::server {

// For whom a section is computed.
struct View {
  proto::Pose pose;
  proto::Lens lens;
  double tau_px = 1;
};

class Metric {
 public:
  Metric(const View& view, bool vertical_errors);

  // Rows of the rotation to view coordinates; z is the depth.
  const glm::dvec3& right() const { return right_; }
  const glm::dvec3& up() const { return up_; }
  const glm::dvec3& forward() const { return forward_; }
  const glm::dvec3& eye() const { return eye_; }

  // A node's centre relative to the eye.
  struct Place {
    double x, y, z;      // view coordinates: right, up, depth
    double horizontal;   // distance from the eye along the ground
  };

  enum class Fit : uint8_t { kOutside, kAcross, kInside };  // a sphere against the frustum

  Fit fit(const Place& p, double radius_m) const {
    const double side = p.z * sin_x_ - std::fabs(p.x) * cos_x_;
    const double top = p.z * sin_y_ - std::fabs(p.y) * cos_y_;
    const double least = std::min(side, top);
    if (least + radius_m < 0) return Fit::kOutside;
    return least >= radius_m ? Fit::kInside : Fit::kAcross;
  }

  bool exceedsTolerance(const Place& p, double radius_m, double error_m) const {
    const double distance = std::sqrt(p.x * p.x + p.y * p.y + p.z * p.z);
    const double z_min = std::max({p.z - radius_m, (distance - radius_m) * cos_corner_, kNearest_m});
    const double lean = std::min((p.horizontal + radius_m) / z_min + lean_floor_, inverse_cos_corner_);
    return error_m * focal_over_tau_ * lean > z_min;
  }

  // Nothing nearer than this is promised anything: metres of depth.
  static constexpr double kNearest_m = 0.1;

 private:
  glm::dvec3 eye_, right_, up_, forward_;
  double sin_x_, cos_x_, sin_y_, cos_y_;  // of half the field of view
  double cos_corner_, inverse_cos_corner_;
  double focal_over_tau_;
  double lean_floor_;  // 0 for vertical errors, infinite otherwise
};

}  // namespace foreland::server
