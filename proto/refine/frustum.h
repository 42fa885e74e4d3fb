// What a camera may see of a sphere while its eye stays near and it turns a little: how near its points may come, and
// whether any lies between the side planes. Both are 1-Lipschitz in the sphere's place and grow (nearer, more inside)
// with its radius. Immutable; any thread.
#pragma once

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>

#include "proto/view.h"

namespace foreland::proto {

class Frustum {
 public:
  // `nearest_m`: no depth is taken to be less.
  Frustum(const View& view, double nearest_m)
      : right_(view.pose.right()), up_(view.pose.up()), forward_(view.pose.forward()), nearest_(nearest_m) {
    const double tan_y = std::tan(0.5 * view.lens.vertical_fov_rad);
    const double tan_x = tan_y * view.lens.width_px / view.lens.height_px;
    cos_x_ = 1 / std::sqrt(1 + tan_x * tan_x);
    sin_x_ = tan_x * cos_x_;
    cos_y_ = 1 / std::sqrt(1 + tan_y * tan_y);
    sin_y_ = tan_y * cos_y_;
    inverse_cos_corner_ = std::sqrt(1 + tan_x * tan_x + tan_y * tan_y);
    cos_corner_ = 1 / inverse_cos_corner_;
    const double turn = std::min(view.turn_rad, 1.5);  // beyond it the frustum covers everything in front anyway
    sin_turn_ = std::sin(turn);
    cos_turn_ = std::cos(turn);
  }

  // View coordinates of a place relative to the eye: right, up, depth.
  glm::dvec3 place(const glm::dvec3& from_eye) const {
    return {glm::dot(from_eye, right_), glm::dot(from_eye, up_), glm::dot(from_eye, forward_)};
  }
  // The least depth of a visible point of the sphere.
  double leastDepth(const glm::dvec3& place, double radius) const {
    const double rho2 = place.x * place.x + place.y * place.y, distance = std::sqrt(rho2 + place.z * place.z);
    const double z = place.z * cos_turn_ - std::sqrt(rho2) * sin_turn_;
    return std::max(std::max(z - radius, (distance - radius) * cos_corner_), nearest_);
  }
  // Signed distance to the nearest side plane, positive inside, when it turns to be the best it can.
  double sideDistance(const glm::dvec3& place) const {
    const double side =
        std::min(place.z * sin_x_ - std::fabs(place.x) * cos_x_, place.z * sin_y_ - std::fabs(place.y) * cos_y_);
    return side * cos_turn_ + std::sqrt(std::max(0.0, glm::dot(place, place) - side * side)) * sin_turn_;
  }
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
