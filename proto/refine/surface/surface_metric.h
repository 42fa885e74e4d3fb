// The refinement test for a node of a surface (S 3.3), in closed form: does its support meet the view, does it not face
// away, and would leaving the node out be seen by more than the tolerance, the silhouette's where it may be on the
// silhouette, the interior's elsewhere? Everything is in the object's frame; scaling an object scales lengths here and
// leaves pixels alone.
//
// Let c be the node seen from the eye, d = |c|, N its normal, g = -N.c and h = |N x c|, R its sphere's radius plus that
// of the region that the eye stays in, q its bulge plus the same. Over all normals m of the cone (half angle A), m .
// (eye - x) for a point x of a triangle of the support is between
//     front = g cos A + h sin A + q      back = g cos A - h sin A - q
// so the support faces away entirely unless front > 0, and may hold a silhouette only if back < 0, too.
//
// An error e moves the image of a point p by f |screen part of e x p| / (z z'), z and z' the depths of p and of p + e.
// Over the sphere |e x p| is at most B = max |e x c| + |e| R, and over the spheroid with semi-axes a and b
//     max |e x c|^2 = max(a^2 h^2 + b^2 g^2, b^2 d^2)
// which are S's conditions (4) and (5), multiplied out and made safe for perspective. (Hoppe's shape: max(a h, b d).)
// With z_min the least depth of a visible point, as in metric.h, the node is needed if
//     f B > tolerance z_min^2    and    f |e| / cos(corner) > tolerance z_min
// the latter since |p| <= z / cos(corner) where p is visible. B takes the middle to be far aside and its sphere's
// points to be near at once; so, with l the middle's distance from the axis, hypot(z_min, l + R) |e| stands for it
// where it is less: |p| / z of a visible point is at most hypot(z_min, l + R) / z_min.
//
// All of this changes by no more than the eye moves (B by sqrt(2) |e| times as much), so the motion that a result is
// sure to survive follows; turning by an angle counts as moving by it times the distance. The basis of adaptation
// by slack (adapter.h).
//
// front, -back, B / z_min^2, |e| only grow and z_min only shrinks when sphere, cone, bulge and shape grow; a parent's
// hold its children's with 1e-6 of the object's size to spare (terrain/surface/bounds.h), far more than rounding here,
// which is below 1e-11 of it wherever the error could be seen. So if a node passes, so do its parents. Element by
// element, without branches, for loops that vectorise. Immutable; any thread.
#pragma once

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>
#include <limits>

#include "proto/refine/metric/frustum.h"
#include "proto/refine/metric/motion_bound.h"
#include "proto/section/surface_bounds.h"
#include "proto/space/view.h"

namespace foreland::proto {

// What the test depends on beside the view, whose tolerance is the silhouette's.
struct SurfaceTest {
  double interior_px = 1;  // where it is less than the silhouette's, it holds there too
  double nearest_m = 0.1;  // metres of depth below which nothing is guaranteed
  bool is_closed = true;   // back faces are not seen
  ErrorShape shape = ErrorShape::kSpheroid;
};

class SurfaceMetric {
 public:
  // `view` in the object's frame.
  SurfaceMetric(const View& view, const SurfaceTest& test)
      : frustum_(view, test.nearest_m),
        eye_(view.pose.eye),
        silhouette_(std::min(view.tau_px, test.interior_px) / view.lens.focalPx()),
        interior_(test.interior_px / view.lens.focalPx()),
        region_radius_(view.region_radius_m),
        min_front_(test.is_closed ? 0 : -std::numeric_limits<double>::infinity()),
        end_on_(test.shape == ErrorShape::kSpheroid ? 1 : 0) {}

  [[gnu::always_inline]] bool passes(const SurfaceBounds& n) const {
    const Seen s = seenFrom(n);
    const Facing f = facingOf(n, s.g, s.h);
    const bool is_silhouette = (f.front > 0) & (f.back > 0);
    const double tolerance = is_silhouette ? silhouette_ : interior_;
    const bool is_visible = (s.B > tolerance * s.z * s.z) & (s.longest * frustum_.inverseCosCorner() > tolerance * s.z);
    return is_visible & (f.front > min_front_) & (s.side_margin >= 0);
  }

  struct TestResult {
    bool passes;
    double slack_m;  // at least 0, and never more than is safe
  };
  [[gnu::always_inline]] TestResult testResult(const SurfaceBounds& n) const {
    const Seen s = seenFrom(n);
    const Facing f = facingOf(n, s.g, s.h);
    // Margins are positive where a condition holds, and measure the motion that it takes to change it. All conditions
    // hold by the least of their margins, any of them by the largest.
    const double as_silhouette = std::min(visibleMargin(s, silhouette_), std::min(f.front, f.back));
    const double visible = std::max(visibleMargin(s, interior_), as_silhouette);
    const double margin = std::min(std::min(visible, f.front - min_front_), s.side_margin);
    return {passes(n), std::fabs(margin)};
  }

  // Distance from the eye, at least the nearest depth.
  double distance(const SurfaceBounds& n) const {
    const double x = n.x - eye_.x, y = n.y - eye_.y, z = n.z - eye_.z;
    return std::max(std::sqrt(x * x + y * y + z * z), frustum_.nearest());
  }
  // The motion from one view to the next, for any slack; lens and kind of surface are the same. A tolerance q times as
  // large acts like depths q times as large, or less.
  static MotionBound motionBoundTo(const View& from, const View& next) {
    const double moved =
        glm::distance(from.pose.eye, next.pose.eye) + std::fabs(next.region_radius_m - from.region_radius_m);
    const double turned = angleBetween(from.pose.orientation, next.pose.orientation) +
                          std::fabs(next.region_angle_rad - from.region_angle_rad);
    const double scaled = std::fabs(next.tau_px / from.tau_px - 1);
    MotionBound motion;
    for (size_t sensitivity = 0; sensitivity < motion.fixed.size(); ++sensitivity)
      motion.set(sensitivity, moved, turned + scaled);
    return motion;
  }

  // Parts of the test, for callers that want to know which one decides.
  bool meetsFrustum(const SurfaceBounds& n) const { return seenFrom(n).side_margin >= 0; }
  // Positive if the support may face the eye, and if it may face away: metres.
  struct Facing {
    double front, back;
  };
  Facing facing(const SurfaceBounds& n) const {
    const Seen s = seenFrom(n);
    return facingOf(n, s.g, s.h);
  }

 private:
  // A node as the eye sees it, in the letters above; z is z_min.
  struct Seen {
    double g, h, z, B, longest, side_margin;
  };
  [[gnu::always_inline]] Seen seenFrom(const SurfaceBounds& n) const {
    const double x = n.x - eye_.x, y = n.y - eye_.y, z = n.z - eye_.z, d2 = x * x + y * y + z * z;
    const ViewPosition position = frustum_.toView(x, y, z);
    const double R = n.radius + region_radius_;
    Seen s;
    s.g = -(n.normal_x * x + n.normal_y * y + n.normal_z * z);
    s.h = std::sqrt(std::max(0.0, d2 - s.g * s.g));
    s.z = frustum_.minDepth(position, R);
    s.longest = std::max(n.along, n.across);
    const double offset = frustum_.largestOffset(position) + R;
    s.B = std::min(errorAcross(n, s.g, s.h, std::sqrt(d2)) + s.longest * R,
                   s.longest * std::sqrt(s.z * s.z + offset * offset));
    s.side_margin = frustum_.sideDistance(position) + R;
    return s;
  }
  [[gnu::always_inline]] Facing facingOf(const SurfaceBounds& n, double g, double h) const {
    const double along = g * std::sqrt(std::max(0.0, 1 - n.sin_cone * n.sin_cone));
    const double across = h * n.sin_cone + n.bulge + region_radius_;
    return {across + along, across - along};
  }
  // Until z + x reaches |e| / (tolerance cos(corner)), or tolerance (z + x)^2 reaches B - kRate |e| x.
  [[gnu::always_inline]] double visibleMargin(const Seen& s, double tolerance) const {
    const double b = 2 * tolerance * s.z + kRate * s.longest, c = s.B - tolerance * s.z * s.z;
    const double across = 2 * c / (b + std::sqrt(std::max(0.0, b * b + 4 * tolerance * c)));
    return std::min(s.longest * frustum_.inverseCosCorner() / tolerance - s.z, across);
  }
  // Largest |e x c| over the error shape.
  [[gnu::always_inline]] double errorAcross(const SurfaceBounds& n, double g, double h, double d) const {
    const double ah = n.along * h, bg = n.across * g, bd = n.across * d;
    return std::max(std::sqrt(ah * ah + end_on_ * (bg * bg)), bd);
  }

  static constexpr double kRate = 1.4142135623730952;  // of B, as a share of |e|, by motion

  Frustum frustum_;
  glm::dvec3 eye_;
  double silhouette_, interior_;  // as shares of the focal length
  double region_radius_;
  double min_front_;  // 0, or no bound for surfaces of which both sides are seen
  double end_on_;     // 1 if the shape seen along its normal has an extent of its own: 0 for Hoppe's
};

}  // namespace foreland::proto
