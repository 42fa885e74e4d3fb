// The refinement test of terrain: does a node's support meet the view, and would leaving the node out be seen by more
// than tau pixels, from anywhere the camera will be until the next keyframe? motion_margin.h says how long its result
// holds.
//
// For a point at view coordinates p (depth z, distance d, horizontal distance h from the eye) an error e moves its
// image by at most  f e d / z^2  if the error may point anywhere, and at most  f e h / z^2  if it is vertical (the
// image displacement is the screen part of e x p), with f the focal length in pixels. The camera stays within the
// view's region: its eye within radius b of the pose's, its axis within the angle w. Over the node's sphere (centre c,
// radius r; R = r + b) every visible point has
//   z >= z_min = max(z cos w - rho sin w - R, (d - R) cos(corner)),  rho = sqrt(d^2 - z^2),   h <= h(c) + R,   d/z <= 1/cos(corner)
// so with K = f e / tau the node is needed if  K / cos(corner) > z_min  and, for vertical errors,  K (h + R) > z_min^2,
// and if the sphere meets the frustum, its planes turned towards it by w (THEORY section 3, the error guarantee; w = b
// = 0 is the keyframe alone).
//
// All conditions only grow with the sphere and the error. A parent's sphere holds its children's with 5e-6 m to spare
// (terrain/bounds) and its error is no smaller, while rounding here stays below 1e-7 m for eyes within 10^8 m; so if a
// node passes, its parents do, in floating point too: the nodes that pass are closed under parents. Immutable; any
// thread.
#pragma once

#include <algorithm>
#include <glm/vec3.hpp>
#include <limits>

#include "proto/refine/metric/frustum.h"
#include "proto/refine/metric/horizon.h"
#include "proto/section/bounds.h"
#include "proto/space/view.h"

namespace foreland::proto {

// A terrain node's centre relative to the eye.
struct NodePosition : ViewPosition {
  double horizontal;  // distance from the eye along the ground
};

class Metric {
 public:
  // With `vertical_errors` errors point up or down, else anywhere.
  Metric(const View& view, bool vertical_errors);
  // On a globe, whose horizon horizon() knows: a node that it hides is not needed, whatever the functions below say.
  // No ground lies above the ceiling.
  Metric(const View& view, const Frame& globe, double ceiling_m);
  const Horizon& horizon() const { return horizon_; }
  bool isOverGlobe() const { return is_over_globe_; }

  const Frustum& frustum() const { return frustum_; }
  const glm::dvec3& eye() const { return eye_; }

  [[gnu::always_inline]] bool passes(const NodePosition& p, double radius_m, double error_m) const {
    const double R = radius_m + region_radius_, z = frustum_.minDepth(p, R), K = error_m * focal_over_tau_;
    const bool is_visible = (K * frustum_.inverseCosCorner() > z) & (K * (p.horizontal + R + any_direction_) > z * z);
    return is_visible & (frustum_.sideDistance(p) + R >= 0);
  }

  // The least quantised error that passes: 256 if none does.
  int leastPassing(const NodePosition& p, double radius_m) const;

  // The least error that passes, up to rounding, metres; infinite if none does.
  [[gnu::always_inline]] double minError(const NodePosition& p, double radius_m) const {
    const double R = radius_m + region_radius_, z = frustum_.minDepth(p, R);
    const double any = z * frustum_.cosCorner(), vertical = z * z / (p.horizontal + R + any_direction_);
    const double least = std::max(any, vertical) / focal_over_tau_;
    return frustum_.sideDistance(p) + R >= 0 ? least : std::numeric_limits<double>::infinity();
  }

  // The terms of the test, in the letters above.
  struct Terms {
    double R, z, K;         // z is z_min
    double any_margin;      // K / cos(corner) - z: positive if an error in any direction would be seen
    double vertical_reach;  // K (h + R): a vertical error is seen from depths up to its root; infinite for other errors
    double side_margin;     // positive if the sphere meets the frustum, by how far it reaches in
  };
  [[gnu::always_inline]] Terms terms(const NodePosition& p, double radius_m, double error_m) const {
    const double R = radius_m + region_radius_, z = frustum_.minDepth(p, R), K = error_m * focal_over_tau_;
    return {R,
            z,
            K,
            K * frustum_.inverseCosCorner() - z,
            K * (p.horizontal + R + any_direction_),
            frustum_.sideDistance(p) + R};
  }
  bool hasVerticalErrors() const { return any_direction_ == 0; }
  double focalOverTau() const { return focal_over_tau_; }
  double regionRadius() const { return region_radius_; }

  // Depth in metres below which nothing is guaranteed: a node is never taken to be nearer.
  static constexpr double kNearest_m = 0.1;
  static constexpr double kEndless_m = 1e9;

 private:
  Frustum frustum_;
  glm::dvec3 eye_;
  double focal_over_tau_;
  double any_direction_;  // 0 for vertical errors; infinite for others, which makes the vertical condition hold
  double region_radius_;
  Horizon horizon_;
  bool is_over_globe_ = false;
};

}  // namespace foreland::proto
