#include "server/section/metric.h"

#include <limits>

namespace foreland::server {

Metric::Metric(const View& view, bool vertical_errors)
    : eye_(view.pose.eye), right_(view.pose.right()), up_(view.pose.up()), forward_(view.pose.forward()) {
  const double tan_y = std::tan(0.5 * view.lens.vertical_fov_rad);
  const double tan_x = tan_y * view.lens.width_px / view.lens.height_px;
  cos_x_ = 1 / std::sqrt(1 + tan_x * tan_x);
  sin_x_ = tan_x * cos_x_;
  cos_y_ = 1 / std::sqrt(1 + tan_y * tan_y);
  sin_y_ = tan_y * cos_y_;
  inverse_cos_corner_ = std::sqrt(1 + tan_x * tan_x + tan_y * tan_y);
  cos_corner_ = 1 / inverse_cos_corner_;
  focal_over_tau_ = view.lens.focalPx() / view.tau_px;
  lean_floor_ = vertical_errors ? 0 : std::numeric_limits<double>::infinity();
  ball_ = view.ball_m;
  const double turn = std::min(view.turn_rad, 1.5);  // beyond it the frustum covers everything in front anyway
  sin_turn_ = std::sin(turn);
  cos_turn_ = std::cos(turn);
}

}  // namespace foreland::server
