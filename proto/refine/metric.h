// The refinement test: does a node's support meet the view, and would leaving the node out be seen by more than tau
// pixels, from anywhere the camera will be until the next keyframe?
//
// For a point at view coordinates p (depth z, distance d, horizontal distance h from the eye) an error e moves its
// image by at most  f e d / z^2  if the error may point anywhere, and at most  f e h / z^2  if it is vertical (the
// image displacement is the screen part of e x p), with f the focal length in pixels. The camera stays in a ball of
// radius b around the pose's eye and turns by at most w. Over the node's sphere (centre c, radius r; R = r + b) every
// visible point has
//   z >= z_min = max(z cos w - rho sin w - R, (d - R) cos(corner)),  rho = sqrt(d^2 - z^2),   h <= h(c) + R,   d/z <= 1/cos(corner)
// so with K = f e / tau the node is needed if  K / cos(corner) > z_min  and, for vertical errors,  K (h + R) > z_min^2,
// and if the sphere meets the frustum, its planes turned towards it by w (DESIGN section 3, the promise; w = b = 0 is
// the keyframe alone).
//
// Both tests only grow with the sphere and the error. A parent's sphere holds its children's with 5e-6 m to spare
// (terrain/bounds) and its error is no smaller, while rounding here stays below 1e-7 m for eyes within 10^8 m; so if a
// node passes, its parents do, in floating point too: the nodes that pass are closed under parents. Immutable; any
// thread.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/vec3.hpp>
#include <limits>

#include "proto/refine/motion_bound.h"
#include "proto/section/bounds.h"
#include "proto/space/view.h"

namespace foreland::proto {

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
    double x, y, z;     // view coordinates: right, up, depth
    double horizontal;  // distance from the eye along the ground
  };

  [[gnu::always_inline]] bool passes(const Place& p, double radius_m, double error_m) const {
    const double R = radius_m + ball_, z = leastDepth(p, R), K = error_m * focal_over_tau_;
    const bool seen = (K * inverse_cos_corner_ > z) & (K * (p.horizontal + R + lean_floor_) > z * z);
    return seen & (sideDistance(p) + R >= 0);
  }

  // The least error class that passes: 256 if none does.
  int leastPassing(const Place& p, double radius_m) const {
    const double guess_m = leastError(p, radius_m);
    if (guess_m == std::numeric_limits<double>::infinity()) return 256;
    int c = QuantisedError::roundUp(std::min(guess_m, 1e9)).value;  // passes() itself decides
    const auto passesAt = [&](int k) { return passes(p, radius_m, QuantisedError{static_cast<uint8_t>(k)}.metres()); };
    while (c < 256 && !passesAt(c)) ++c;
    while (c > 0 && c < 256 && passesAt(c - 1)) --c;
    return c;
  }

  // The least error that passes, up to rounding; infinite if none does.
  [[gnu::always_inline]] double leastError(const Place& p, double radius_m) const {
    const double R = radius_m + ball_, z = leastDepth(p, R);
    const double near = z * cos_corner_, lean = z * z / (p.horizontal + R + lean_floor_);
    const double least = std::max(near, lean) / focal_over_tau_;
    return sideDistance(p) + R >= 0 ? least : std::numeric_limits<double>::infinity();
  }

  // How far the camera may move for an outcome of passes() to stand: the basis of adapter.h. A guard says how motion
  // counts; the camera goes ahead (on the level, to where it looks), up or down, and aside.
  //   kMotion   it stands until the motion reaches `slack`
  //   kTowardsSidePlane   it fails because it lies beside the frustum: until a side plane nears it by `slack`
  //   kApproach    it fails because it would not be seen: until the way nearer to it plus kStray times any other motion
  //             reaches `slack`
  //   kAdvance   it passes: until the way ahead, up and down plus kAdvanceStray times any other motion and the growth of
  //             depth reaches `slack`
  enum class Sensitivity : uint8_t { kMotion = 0, kTowardsSidePlane = 1, kApproach = 2, kAdvance = 3 };
  struct TestResult {
    Sensitivity sensitivity;
    double slack;  // metres, 0 or more, never too much
  };
  static constexpr double kStray = 3, kAdvanceStray = 12;

  // Depth, horizontal and side distance change by at most the motion s (they are 1-Lipschitz). What passes does so
  // until
  //   z + s reaches K / cos(corner), (z + s)^2 reaches K (h + R - s), or the sphere leaves the frustum;
  // and what fails does so until all the conditions that fail can hold, so any one of them may stand guard.
  //
  // kApproach. Let q = sqrt(K (h + R)); the node fails since z > q. Going ahead by a takes at most a off z and at least
  // t a off h while the angle to straight ahead has a cosine of t or more; any other motion s takes s off z and
  // adds s to h. sqrt is concave, so z - q falls by at most (1 - t K / 2q) a + (1 + K / 2q) s, and (what lies straight
  // ahead) - t h by at most a + (1 + t) s. The t is taken that leaves room for twice the gap.
  //
  // kAdvance. Let z = max(z1, z2), the first term and the corner's. Going ahead by a takes at least a `sinking` off z1,
  // adds nothing to z2 while the node lies ahead, and takes at most a off h; up and down by v changes no h, and z2 by
  // less than v. Both conditions, K (h + R) > z1^2 and K (h + R) > z2^2, are concave in all motions, so they hold
  // between them and none if they hold at each alone.
  //
  // Of those that may stand guard the one is taken that lasts longest at this pace.
  [[gnu::always_inline]] TestResult testResult(const Place& p, double radius_m, double error_m,
                                               const MotionBound& pace) const {
    const bool passed = passes(p, radius_m, error_m);
    const double R = radius_m + ball_, z = leastDepth(p, R), K = error_m * focal_over_tau_;
    const double near_room = K * inverse_cos_corner_ - z, side_room = sideDistance(p) + R;
    // s^2 + b s - c = 0 if passed (c > 0), s^2 - b s - c = 0 if not: the smaller root's size is the same expression.
    const double b = 2 * z + K, c = K * (p.horizontal + R) - z * z;
    const double lean_room = std::max(2 * c / (b + std::sqrt(std::max(0.0, b * b + 4 * c))), lean_room_floor_);
    const double seen_room = std::min(near_room, lean_room);
    const double lean = K * (p.horizontal + R + lean_floor_), straight = straightAhead(p);

    const double motion_room = passed ? std::min(seen_room, side_room) : -seen_room;
    const double special_room = passed ? std::min(std::min(advanceMargin(p, R, K, lean), kAdvanceStray * seen_room),
                                                  std::min(side_room, straight))
                                       : std::max(-near_room, approachMargin(p, z, K, lean));

    const double distance = std::sqrt(p.x * p.x + p.y * p.y + p.z * p.z);
    const auto lasts = [&](double room_m, Sensitivity sensitivity) {
      return room_m / pace.of(static_cast<size_t>(sensitivity), distance);
    };
    const double motion = lasts(motion_room, Sensitivity::kMotion),
                 beside = passed ? 0 : lasts(-side_room, Sensitivity::kTowardsSidePlane);
    const double special =
        passed ? lasts(special_room, Sensitivity::kAdvance) : lasts(special_room, Sensitivity::kApproach);
    const bool is_special = special > motion, is_beside = beside > std::max(special, motion);
    return {is_beside    ? Sensitivity::kTowardsSidePlane
            : is_special ? (passed ? Sensitivity::kAdvance : Sensitivity::kApproach)
                         : Sensitivity::kMotion,
            std::max(0.0, is_beside    ? -side_room
                          : is_special ? special_room
                                       : motion_room)};
  }

  // From the view of this metric to `next`, which has the same lens and kind of error.
  MotionBound motionBoundTo(const View& from, const View& next) const;

  // Nothing nearer than this is promised anything: metres of depth.
  static constexpr double kNearest_m = 0.1;
  static constexpr double kEndless_m = 1e9;

 private:
  // Signed distance to the nearest side plane of the frustum, positive inside, when it turns by up to w to be the best
  // it can.
  [[gnu::always_inline]] double sideDistance(const Place& p) const {
    const double side = std::min(p.z * sin_x_ - std::fabs(p.x) * cos_x_, p.z * sin_y_ - std::fabs(p.y) * cos_y_);
    const double d2 = p.x * p.x + p.y * p.y + p.z * p.z;
    return side * cos_turn_ + std::sqrt(std::max(0.0, d2 - side * side)) * sin_turn_;
  }
  // The terms of z_min: along the axis, and for the frustum's corners.
  [[gnu::always_inline]] double axisDepth(const Place& p, double R) const {
    return p.z * cos_turn_ - std::sqrt(p.x * p.x + p.y * p.y) * sin_turn_ - R;
  }
  [[gnu::always_inline]] double cornerDepth(const Place& p, double R) const {
    return std::max((std::sqrt(p.x * p.x + p.y * p.y + p.z * p.z) - R) * cos_corner_, kNearest_m);
  }
  [[gnu::always_inline]] double leastDepth(const Place& p, double R) const {
    return std::max(axisDepth(p, R), cornerDepth(p, R));
  }

  // How far the place lies on the level to where the camera looks, or less.
  [[gnu::always_inline]] double straightAhead(const Place& p) const {
    return p.x * ahead_.x + p.y * ahead_.y + p.z * ahead_.z;
  }
  // Of kApproach, from vertical errors: `lean` is K (h + R).
  [[gnu::always_inline]] double approachMargin(const Place& p, double z, double K, double lean) const {
    const double q = std::sqrt(lean), lift = 0.5 * K / (q + 1e-300), straight = straightAhead(p), gap = z - q;
    const double t = std::min(1.0, std::max(0.0, (straight - 2 * gap) / (p.horizontal + 1e-300)));
    return std::min(straight - t * p.horizontal, gap / std::max(1 - t * lift, (1 + lift) / kStray));
  }
  // Of kAdvance, by going ahead and up or down alone, while the node lies ahead.
  [[gnu::always_inline]] double advanceMargin(const Place& p, double R, double K, double lean) const {
    const double z1 = axisDepth(p, R), z2 = cornerDepth(p, R), least_K = K + 1e-300;
    const double under1 = std::max((lean - z1 * z1) / least_K, (2 * z1 * sinking_ - K) * per_sinking2_);
    const double under2 = std::min((lean - z2 * z2) / least_K, std::sqrt(lean) - z2);
    return std::min(std::max(lean_room_floor_, std::min(under1, under2)), K * inverse_cos_corner_ - z2);
  }

  glm::dvec3 eye_, right_, up_, forward_;
  glm::dvec3 level_;  // forward without its part upwards, in the scene's frame: not a unit vector
  glm::dvec3 ahead_;  // the same in view coordinates
  double sinking_;    // what going ahead by one takes off the depth at least, however the view turns
  double per_sinking2_;
  double sin_x_, cos_x_, sin_y_, cos_y_;  // of half the field of view
  double cos_corner_, inverse_cos_corner_;
  double focal_over_tau_;
  double lean_floor_;       // 0 for vertical errors, infinite otherwise
  double lean_room_floor_;  // -infinite for vertical errors, endless otherwise
  double ball_, sin_turn_, cos_turn_;
};

}  // namespace foreland::proto
