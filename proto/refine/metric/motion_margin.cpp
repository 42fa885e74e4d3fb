#include "proto/refine/metric/motion_margin.h"

#include <glm/geometric.hpp>
#include <limits>

namespace foreland::proto {

MotionMargin::MotionMargin(const Metric& metric) : metric_(metric) {
  const Frustum& frustum = metric.frustum();
  level_ = {frustum.forward().x, frustum.forward().y, 0};
  ahead_ = {glm::dot(frustum.right(), level_), glm::dot(frustum.up(), level_), glm::dot(frustum.forward(), level_)};
  sinking_ = std::max(0.0, glm::length(level_) * frustum.cosAngle() - frustum.sinAngle());
  per_sinking2_ = 1 / (sinking_ * sinking_ + 1e-300);
  min_vertical_margin_ = metric.hasVerticalErrors() ? -std::numeric_limits<double>::infinity() : Metric::kEndless_m;
}

// The eye moves first, then turns. Moving by t changes depth by exactly -t.z and side distances by -t.n; turning moves
// a view-space position by at most angle * distance. A tolerance q times as large acts like depths q times as large: z
// < K / q is q z < K, and z^2 < K h / q is implied by (q z)^2 < K h for q > 1, and the other way round for q < 1.
MotionBound MotionMargin::motionBoundTo(const View& from, const View& next) const {
  const Frustum& frustum = metric_.frustum();
  const glm::dvec3 move = next.pose.eye - from.pose.eye;
  const ViewPosition seen{glm::dot(move, frustum.right()), glm::dot(move, frustum.up()),
                          glm::dot(move, frustum.forward())};
  const double moved = glm::length(move), region = std::fabs(next.region_radius_m - from.region_radius_m);
  const double swept = std::sqrt(seen.x * seen.x + seen.y * seen.y) * frustum.sinAngle();
  const double turned = angleBetween(from.pose.orientation, next.pose.orientation) +
                        std::fabs(next.region_angle_rad - from.region_angle_rad);
  const double scaled = std::fabs(next.tau_px / from.tau_px - 1);

  const double level = std::max(glm::length(level_), 1e-9), ahead = std::max(0.0, glm::dot(move, level_) / level);
  const double aside = glm::length(glm::dvec2(move) - glm::dvec2(level_) * (ahead / level));
  const double nearer = std::max(seen.z * frustum.cosAngle() + swept, moved * frustum.cosCorner());
  const double rising = std::max(0.0, swept - seen.z * frustum.cosAngle() + sinking_ * ahead);
  MotionBound motion;
  const auto set = [&](Sensitivity sensitivity, double fixed, double per_distance) {
    motion.set(static_cast<size_t>(sensitivity), fixed, per_distance);
  };
  set(Sensitivity::kMotion, moved + region, turned + scaled);
  const double least = kMinCharge * moved;
  set(Sensitivity::kTowardsSidePlane, std::max(least, frustum.sideApproach(seen, moved)) + region, turned);
  set(Sensitivity::kApproach,
      std::max({least, nearer, ahead * level}) + kStray * (std::max(0.0, nearer - ahead) + aside + region),
      kStray * (turned + scaled));
  set(Sensitivity::kAdvance, ahead + std::fabs(move.z) + kAdvanceStray * (aside + rising + region),
      kAdvanceStray * (turned + scaled));
  return motion;
}

}  // namespace foreland::proto
