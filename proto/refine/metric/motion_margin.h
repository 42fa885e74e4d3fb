// How far the camera may move before a result of the refinement test (metric.h) can change: the margin of the result,
// and the motion between two views to be taken off such margins. Adaptation skips tests whose margin is not used up yet
// (adapter.h). Immutable; any thread.
//
// A result names the kind of motion that it is sensitive to, for a camera mostly goes ahead, and a node seen from the
// side or far away survives much of that. The camera's motion is taken apart into ahead (on the level, to where it
// looks), up or down, and aside.
//   kMotion            the result stands until the motion reaches the margin
//   kTowardsSidePlane  fails because the node lies beside the frustum: stands until a side plane nears it by the margin
//   kApproach          fails because the error would not be seen: stands until the approach towards the node plus kStray
//                      times any other motion reaches the margin
//                      Both take kMinCharge of any motion, else the camera might fly away from the node for nothing,
//                      and turns, charged by the distance (MotionConstraint), would be charged too little afterwards.
//   kAdvance           passes: stands until the motion ahead, up and down plus kAdvanceStray times any other motion and
//                      the growth of depth reaches the margin
//
// Depth, horizontal and side distance change by at most the motion s (they are 1-Lipschitz). A node that passes does so
// until
//   z + s reaches K / cos(corner), (z + s)^2 reaches K (h + R - s), or the sphere leaves the frustum;
// and one that fails does so until all the conditions that fail can hold, so the margin of any one of them will do.
//
// kApproach. Let q = sqrt(K (h + R)); the node fails since z > q. Going ahead by a takes at most a off z and at least
// t a off h while the angle to straight ahead has a cosine of t or more; any other motion s takes s off z and
// adds s to h. sqrt is concave, so z - q falls by at most (1 - t K / 2q) a + (1 + K / 2q) s, and (the distance straight
// ahead) - t h by at most a + (1 + t) s. The t is taken that leaves a margin of twice the gap z - q.
//
// kAdvance. Let z = max(z1, z2), the bounds by axis and by corner. Going ahead by a takes at least a times `sinking`
// off z1, adds nothing to z2 while the node lies ahead, and takes at most a off h; up and down by v changes no h, and
// z2 by less than v. Both conditions, K (h + R) > z1^2 and K (h + R) > z2^2, are concave in all motions, so they hold
// for a mixture of motions if they hold for each alone.
//
// Of the sensitivities that are valid for a result, the one is taken whose margin lasts longest at the pace given.
#pragma once

#include <algorithm>
#include <cmath>
#include <glm/vec3.hpp>

#include "proto/refine/metric/metric.h"
#include "proto/refine/metric/motion_bound.h"

namespace foreland::proto {

enum class Sensitivity : uint8_t { kMotion = 0, kTowardsSidePlane = 1, kApproach = 2, kAdvance = 3 };

struct TestResult {
  Sensitivity sensitivity;
  double slack;  // metres; at least 0, and never more than is safe
};

class MotionMargin {
 public:
  explicit MotionMargin(const Metric& metric);

  const Metric& metric() const { return metric_; }

  static constexpr double kStray = 3, kAdvanceStray = 12, kMinCharge = 0.25;

  // Which motion the result of metric.passes() with the same arguments is sensitive to, and how much of it is safe.
  [[gnu::always_inline]] TestResult testResult(const NodePosition& p, double radius_m, double error_m,
                                               const MotionBound& pace) const {
    const bool passed = metric_.passes(p, radius_m, error_m);
    const Metric::Terms n = metric_.terms(p, radius_m, error_m);
    const double z = n.z, K = n.K;
    // s^2 + b s - c = 0 if passed (c > 0), s^2 - b s - c = 0 if not: the smaller root's size is the same expression.
    const double b = 2 * z + K, c = K * (p.horizontal + n.R) - z * z;
    const double vertical_margin =
        std::max(2 * c / (b + std::sqrt(std::max(0.0, b * b + 4 * c))), min_vertical_margin_);
    const double visible_margin = std::min(n.any_margin, vertical_margin);

    const double motion_margin = passed ? std::min(visible_margin, n.side_margin) : -visible_margin;
    const double special_margin = passed ? std::min(std::min(advanceMargin(p, n), kAdvanceStray * visible_margin),
                                                    std::min(n.side_margin, straightAhead(p)))
                                         : std::max(-n.any_margin, approachMargin(p, n));

    // Margins over paces are compared by their products with the other pace: divisions take longest here.
    const double distance = std::sqrt(p.x * p.x + p.y * p.y + p.z * p.z);
    const auto paceOf = [&](Sensitivity sensitivity) { return pace.of(static_cast<size_t>(sensitivity), distance); };
    const double motion_pace = paceOf(Sensitivity::kMotion), beside_pace = paceOf(Sensitivity::kTowardsSidePlane),
                 special_pace = passed ? paceOf(Sensitivity::kAdvance) : paceOf(Sensitivity::kApproach),
                 beside_margin = -n.side_margin;  // not positive if passed
    const bool is_special = special_margin * motion_pace > motion_margin * special_pace,
               is_beside = (beside_margin * motion_pace > motion_margin * beside_pace) &
                           (beside_margin * special_pace > special_margin * beside_pace);
    return {is_beside    ? Sensitivity::kTowardsSidePlane
            : is_special ? (passed ? Sensitivity::kAdvance : Sensitivity::kApproach)
                         : Sensitivity::kMotion,
            std::max(0.0, is_beside    ? beside_margin
                          : is_special ? special_margin
                                       : motion_margin)};
  }

  // How much farther away the node can be while the slack of such a result lasts, at most.
  [[gnu::always_inline]] static double maxGrowthOfDistance(Sensitivity sensitivity, double slack) {
    const bool goes_free = sensitivity == Sensitivity::kTowardsSidePlane || sensitivity == Sensitivity::kApproach;
    return goes_free ? slack / kMinCharge : slack;
  }

  // The motion from the view of this metric to `next`, which has the same lens and kind of error.
  MotionBound motionBoundTo(const View& from, const View& next) const;

 private:
  // A lower bound on the distance of the position along the level, to where the camera looks.
  [[gnu::always_inline]] double straightAhead(const ViewPosition& p) const {
    return p.x * ahead_.x + p.y * ahead_.y + p.z * ahead_.z;
  }
  // The margin of kApproach by the condition of vertical errors.
  [[gnu::always_inline]] double approachMargin(const NodePosition& p, const Metric::Terms& n) const {
    const double q = std::sqrt(n.vertical_reach), slope = 0.5 * n.K / (q + 1e-300), straight = straightAhead(p),
                 gap = n.z - q;
    const double t = std::min(1.0, std::max(0.0, (straight - 2 * gap) / (p.horizontal + 1e-300)));
    return std::min(straight - t * p.horizontal, gap / std::max(1 - t * slope, (1 + slope) * (1 / kStray)));
  }
  // The margin of kAdvance by going ahead and up or down alone, while the node lies ahead.
  [[gnu::always_inline]] double advanceMargin(const NodePosition& p, const Metric::Terms& n) const {
    const Frustum& frustum = metric_.frustum();
    const double z1 = frustum.axisDepth(p, n.R), z2 = frustum.cornerDepth(p, n.R), per_K = 1 / (n.K + 1e-300);
    const double by_axis = std::max((n.vertical_reach - z1 * z1) * per_K, (2 * z1 * sinking_ - n.K) * per_sinking2_);
    const double by_corner = std::min((n.vertical_reach - z2 * z2) * per_K, std::sqrt(n.vertical_reach) - z2);
    return std::min(std::max(min_vertical_margin_, std::min(by_axis, by_corner)),
                    n.K * frustum.inverseCosCorner() - z2);
  }

  Metric metric_;     // a copy: its own memory, so that loops over batches vectorise
  glm::dvec3 level_;  // forward without its upward part, in the scene's axes: not a unit vector
  glm::dvec3 ahead_;  // the same in view coordinates
  double sinking_;    // the least that going ahead by one takes off the axis depth, however the camera turns
  double per_sinking2_;
  double min_vertical_margin_;  // -infinite for vertical errors; endless for others, which have no such condition
};

}  // namespace foreland::proto
