// What a camera may see of a sphere while its eye stays near and it turns a little: how near its points may come, and
// whether any lies between the side planes. Both are 1-Lipschitz in the sphere's place and grow (nearer, more inside)
// with its radius; so is how far aside its middle may come. Immutable; any thread.
#pragma once

#include <algorithm>
#include <cmath>
#include <glm/vec3.hpp>

#include "proto/space/trig.h"
#include "proto/space/view.h"

namespace foreland::proto {

class Frustum {
 public:
  // `nearest_m`: no depth is taken to be less.
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
    const double turn =
        std::min(view.region_angle_rad, 1.5);  // beyond it the frustum covers everything in front anyway
    sin_turn_ = sinCos(turn).sin;
    cos_turn_ = sinCos(turn).cos;
  }

  // A place relative to the eye in view coordinates: right, up, depth.
  struct Place {
    double x, y, z;
  };
  [[gnu::always_inline]] Place place(double x, double y, double z) const {
    return {x * right_.x + y * right_.y + z * right_.z, x * up_.x + y * up_.y + z * up_.z,
            x * forward_.x + y * forward_.y + z * forward_.z};
  }
  // The least depth of a visible point of the sphere.
  [[gnu::always_inline]] double leastDepth(const Place& p, double radius) const {
    const double rho2 = p.x * p.x + p.y * p.y, distance = std::sqrt(rho2 + p.z * p.z);
    const double z = p.z * cos_turn_ - std::sqrt(rho2) * sin_turn_;
    return std::max(std::max(z - radius, (distance - radius) * cos_corner_), nearest_);
  }
  // How far from the axis the sphere's middle comes, at most, while it is in front.
  [[gnu::always_inline]] double mostAside(const Place& p) const {
    const double rho = std::sqrt(p.x * p.x + p.y * p.y), distance = std::sqrt(rho * rho + p.z * p.z);
    return p.z * cos_turn_ - rho * sin_turn_ > 0 ? rho * cos_turn_ + p.z * sin_turn_ : distance;
  }
  // Signed distance to the nearest side plane, positive inside, when it turns to be the best it can.
  [[gnu::always_inline]] double sideDistance(const Place& p) const {
    const double side = std::min(p.z * sin_x_ - std::fabs(p.x) * cos_x_, p.z * sin_y_ - std::fabs(p.y) * cos_y_);
    const double d2 = p.x * p.x + p.y * p.y + p.z * p.z;
    return side * cos_turn_ + std::sqrt(std::max(0.0, d2 - side * side)) * sin_turn_;
  }
  double nearest() const { return nearest_; }  // metres of depth
  // Distance over depth, at most, of a visible point.
  double inverseCosCorner() const { return inverse_cos_corner_; }

 private:
  glm::dvec3 right_, up_, forward_;
  double nearest_;
  double sin_x_, cos_x_, sin_y_, cos_y_;  // of half the field of view
  double cos_corner_, inverse_cos_corner_;
  double sin_turn_, cos_turn_;
};

}  // namespace foreland::proto
