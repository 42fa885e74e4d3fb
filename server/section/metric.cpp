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

// Every quantity in the tests is 1-Lipschitz in the place: depth, horizontal distance and side distance each change by at most
// the motion s. With K = f e / tau the tolerance is exceeded while both  K / cos(corner) > z  and  K (h + R) > z^2, so
//   passed:  until  z + s  reaches K / cos(corner), or (z + s)^2 reaches K (h + R - s), or the sphere leaves the frustum
//   failed:  until all of the conditions that fail now can hold: the last of them decides
double Metric::slack(const Place& p, double radius_m, double error_m, bool passed) const {
  const double R = radius_m + ball_, z = leastDepth(p, R), K = error_m * focal_over_tau_;
  const double near_limit = K * inverse_cos_corner_;
  double seen = near_limit - z;
  if (lean_floor_ == 0) {
    // s^2 + b s - c = 0 if passed (c > 0), s^2 - b s - c = 0 if not: the smaller root's size is the same expression.
    const double b = 2 * z + K, c = K * (p.horizontal + R) - z * z;
    seen = std::min(seen, 2 * c / (b + std::sqrt(std::max(0.0, b * b + 4 * c))));
  }
  const double inside = sweptSide(p, sideDistance(p)) + R;
  const double least = std::min(seen, inside);
  return passed ? std::max(0.0, least) : std::max(0.0, -least);
}

}  // namespace foreland::server
