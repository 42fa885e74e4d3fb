// What a camera may see of a sphere while its eye stays within a region and it turns within an angle: how near a
// visible point of the sphere may come, and whether any point lies between the side planes. Depths and side distances
// change by no more than the sphere's centre moves; they grow (nearer, further inside) with its radius. Immutable; any
// thread.
#pragma once

#include <algorithm>
#include <cmath>
#include <glm/vec3.hpp>

#include "proto/space/trig.h"
#include "proto/space/view.h"

namespace foreland::proto {

// A point relative to the eye, metres: to the right, up, and depth along the view's axis.
struct ViewPosition {
  double x, y, z;
};

class Frustum {
 public:
  // `nearest_m`: every depth is taken to be at least this.
  Frustum(const View& view, double nearest_m)
      : right_(view.pose.right()), up_(view.pose.up()), forward_(view.pose.forward()), nearest_(nearest_m) {
    const double tan_y = view.lens.tanHalfFov();
    const double tan_x = tan_y * view.lens.width_px / view.lens.height_px;
    cos_x_ = 1 / std::sqrt(1 + tan_x * tan_x);
    sin_x_ = tan_x * cos_x_;
    cos_y_ = 1 / std::sqrt(1 + tan_y * tan_y);
    sin_y_ = tan_y * cos_y_;
    inverse_cos_corner_ = std::sqrt(1 + tan_x * tan_x + tan_y * tan_y);
    cos_corner_ = 1 / inverse_cos_corner_;
    const double angle =
        std::min(view.region_angle_rad, 1.5);  // beyond it the frustum covers everything in front anyway
    sin_angle_ = sinCos(angle).sin;
    cos_angle_ = sinCos(angle).cos;
  }

  // Rows of the rotation from the scene's axes to the view's.
  const glm::dvec3& right() const { return right_; }
  const glm::dvec3& up() const { return up_; }
  const glm::dvec3& forward() const { return forward_; }

  // Of a point relative to the eye along the scene's axes.
  [[gnu::always_inline]] ViewPosition toView(double x, double y, double z) const {
    return {x * right_.x + y * right_.y + z * right_.z, x * up_.x + y * up_.y + z * up_.z,
            x * forward_.x + y * forward_.y + z * forward_.z};
  }

  // Two lower bounds on the depth of a visible point of the sphere: by its distance along the axis, when the camera has
  // turned away from it as far as it may; and by its distance from the eye, for no visible point is further from the
  // axis than the frustum's corners.
  [[gnu::always_inline]] double axisDepth(const ViewPosition& centre, double radius) const {
    return centre.z * cos_angle_ - std::sqrt(centre.x * centre.x + centre.y * centre.y) * sin_angle_ - radius;
  }
  [[gnu::always_inline]] double cornerDepth(const ViewPosition& centre, double radius) const {
    const double distance = std::sqrt(centre.x * centre.x + centre.y * centre.y + centre.z * centre.z);
    return std::max((distance - radius) * cos_corner_, nearest_);
  }
  [[gnu::always_inline]] double minDepth(const ViewPosition& centre, double radius) const {
    return std::max(axisDepth(centre, radius), cornerDepth(centre, radius));
  }
  // The largest distance of the sphere's centre from the axis while it is in front of the camera.
  [[gnu::always_inline]] double largestOffset(const ViewPosition& p) const {
    const double rho = std::sqrt(p.x * p.x + p.y * p.y), distance = std::sqrt(rho * rho + p.z * p.z);
    return p.z * cos_angle_ - rho * sin_angle_ > 0 ? rho * cos_angle_ + p.z * sin_angle_ : distance;
  }
  // Signed distance to the nearest side plane, positive inside, for the turn of the camera that makes it largest.
  [[gnu::always_inline]] double sideDistance(const ViewPosition& p) const {
    const double side = std::min(p.z * sin_x_ - std::fabs(p.x) * cos_x_, p.z * sin_y_ - std::fabs(p.y) * cos_y_);
    const double d2 = p.x * p.x + p.y * p.y + p.z * p.z;
    return side * cos_angle_ + std::sqrt(std::max(0.0, d2 - side * side)) * sin_angle_;
  }
  // How much sideDistance() of any point can grow when the eye moves by `move` (view coordinates), `length` metres.
  double sideApproach(const ViewPosition& move, double length) const {
    // The side planes' normals point inward: (-+cos, 0, sin) and (0, -+cos, sin).
    return std::max(0.0, std::max(std::fabs(move.x) * cos_x_ - move.z * sin_x_,
                                  std::fabs(move.y) * cos_y_ - move.z * sin_y_)) +
           length * sin_angle_;
  }

  double nearest() const { return nearest_; }  // metres of depth
  // Of half the field of view, across and upright.
  struct Sides {
    double sin_x, cos_x, sin_y, cos_y;
  };
  Sides sides() const { return {sin_x_, cos_x_, sin_y_, cos_y_}; }
  double cosCorner() const { return cos_corner_; }
  // The largest ratio of distance to depth of a visible point.
  double inverseCosCorner() const { return inverse_cos_corner_; }
  // Of the angle by which the camera may turn.
  double sinAngle() const { return sin_angle_; }
  double cosAngle() const { return cos_angle_; }

 private:
  glm::dvec3 right_, up_, forward_;
  double nearest_;
  double sin_x_, cos_x_, sin_y_, cos_y_;  // of half the field of view
  double cos_corner_, inverse_cos_corner_;
  double sin_angle_, cos_angle_;
};

}  // namespace foreland::proto
