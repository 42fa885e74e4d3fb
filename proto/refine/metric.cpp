#include "proto/refine/metric.h"

#include <glm/geometric.hpp>

#include "proto/space/trig.h"

namespace foreland::proto {

Metric::Metric(const View& view, bool vertical_errors)
    : eye_(view.pose.eye),
      right_(view.pose.right()),
      up_(view.pose.up()),
      forward_(view.pose.forward()),
      level_(forward_.x, forward_.y, 0),
      ahead_(glm::dot(right_, level_), glm::dot(up_, level_), glm::dot(forward_, level_)) {
  const double tan_y = view.lens.tanHalfFov();
  const double tan_x = tan_y * view.lens.width_px / view.lens.height_px;
  cos_x_ = 1 / std::sqrt(1 + tan_x * tan_x);
  sin_x_ = tan_x * cos_x_;
  cos_y_ = 1 / std::sqrt(1 + tan_y * tan_y);
  sin_y_ = tan_y * cos_y_;
  inverse_cos_corner_ = std::sqrt(1 + tan_x * tan_x + tan_y * tan_y);
  cos_corner_ = 1 / inverse_cos_corner_;
  focal_over_tau_ = view.lens.focalPx() / view.tau_px;
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  lean_floor_ = vertical_errors ? 0 : kInfinity;
  lean_room_floor_ = vertical_errors ? -kInfinity : kEndless_m;
  ball_ = view.region_radius_m;
  const double turn = std::min(view.region_angle_rad, 1.5);  // beyond it the frustum covers everything in front anyway
  sin_turn_ = sinCos(turn).sin;
  cos_turn_ = sinCos(turn).cos;
  sinking_ = std::max(0.0, glm::length(level_) * cos_turn_ - sin_turn_);
  per_sinking2_ = 1 / (sinking_ * sinking_ + 1e-300);
}

// The eye moves first, then turns. Moving by t changes depth by exactly -t.z and side distances by -t.n; turning moves
// a place by at most angle * distance. A tolerance q times as large acts like depths q times as large: z < K / q is q z
// < K, and z^2 < K h / q is implied by (q z)^2 < K h for q > 1, and the other way round for q < 1.
MotionBound Metric::motionBoundTo(const View& from, const View& next) const {
  const glm::dvec3 move = next.pose.eye - from.pose.eye;
  const double x = glm::dot(move, right_), y = glm::dot(move, up_), z = glm::dot(move, forward_);
  const double moved = glm::length(move), ball = std::fabs(next.region_radius_m - from.region_radius_m);
  const double swept = std::sqrt(x * x + y * y) * sin_turn_;
  // Side planes look inward: (-+cos, 0, sin) and (0, -+cos, sin).
  const double beside =
      std::max(0.0, std::max(std::fabs(x) * cos_x_ - z * sin_x_, std::fabs(y) * cos_y_ - z * sin_y_)) +
      moved * sin_turn_;
  const double turned = angleBetween(from.pose.orientation, next.pose.orientation) +
                        std::fabs(next.region_angle_rad - from.region_angle_rad);
  const double scaled = std::fabs(next.tau_px / from.tau_px - 1);

  const double level = std::max(glm::length(level_), 1e-9), ahead = std::max(0.0, glm::dot(move, level_) / level);
  const double aside = glm::length(glm::dvec2(move) - glm::dvec2(level_) * (ahead / level));
  const double nearer = std::max(z * cos_turn_ + swept, moved * cos_corner_);
  const double rising = std::max(0.0, swept - z * cos_turn_ + sinking_ * ahead);
  MotionBound motion;
  const auto set = [&](Sensitivity sensitivity, double fixed, double per_distance) {
    motion.set(static_cast<size_t>(sensitivity), fixed, per_distance);
  };
  set(Sensitivity::kMotion, moved + ball, turned + scaled);
  set(Sensitivity::kTowardsSidePlane, beside + ball, turned);
  set(Sensitivity::kApproach, std::max(nearer, ahead * level) + kStray * (std::max(0.0, nearer - ahead) + aside + ball),
      kStray * (turned + scaled));
  set(Sensitivity::kAdvance, ahead + std::fabs(move.z) + kAdvanceStray * (aside + rising + ball),
      kAdvanceStray * (turned + scaled));
  return motion;
}

}  // namespace foreland::proto
