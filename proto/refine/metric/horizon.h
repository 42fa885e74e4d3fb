// What a planet hides behind its horizon: a ball that no ground reaches into stands before it. Of a view, and of a
// sphere's centre relative to the eye in view coordinates.
//
// Lengths along the axis are stretched until the spheroid is a ball of radius A, so that the ball inside, which begins
// where the lowest ground may lie, is as large as it can be: straight lines stay straight, and spheres grow by no more
// than the stretch g. A point is hidden if the segment to it from the eye e meets the ball (centre 0, radius q). Those
// beyond the plane of the tangent circle and inside the cone of tangents are, a convex set; so what is drawn between
// hidden vertices is hidden, whatever mesh it belongs to. With D = |e|, and z and r of the point along and across the
// axis from the eye to the centre,
//   cone   z q/D - r sqrt(1 - q^2/D^2)          plane   z - (D^2 - q^2)/D
// are how far it lies inside; a sphere is hidden if both are at least its radius. An eye that moves by s
// leaves segments within s, so what is hidden from it for a ball q is in the cone before for q + s, and the other way
// round: that answers for the region of a keyframe and, with how the plane turns, for the motion that a result
// survives.
//
// Both measures shrink with a sphere that lies in another, whatever rounding does, as metric.h demands: no squares are
// subtracted. Immutable; any thread.
#pragma once

#include <algorithm>
#include <cmath>
#include <glm/vec3.hpp>

#include "proto/refine/metric/frustum.h"
#include "proto/space/frame.h"

namespace foreland::proto {

class Horizon {
 public:
  // Hides nothing.
  Horizon() = default;
  // Of a globe.
  Horizon(const Frame& frame, const View& view, const Frustum& frustum);

  bool hidesAnything() const { return ball_ > 0; }
  [[gnu::noinline]] bool hides(const ViewPosition& p, double radius_m) const {
    if (!hidesAnything()) return false;
    const Inside in = inside(p);
    return std::min(in.cone, in.plane) >= radius_m * stretch_;
  }
  // How far the eye may surely move, metres, before hides() says something else; at least 0.
  [[gnu::noinline]] double slack(const ViewPosition& p, double radius_m) const {
    if (!hidesAnything()) return slack_if_useless_m_;
    const Inside in = inside(p);
    const double cone = in.cone - radius_m * stretch_, plane = in.plane - radius_m * stretch_;
    // The plane's normal turns by 4/3 of s / D at most, while s is less than half of D, about the centre.
    const double to_centre = distance_ - in.along,
                 from_centre = std::sqrt(in.across * in.across + to_centre * to_centre),
                 until_plane = std::min(0.5 * distance_, std::fabs(plane) / (2 + 1.34 * from_centre / distance_));
    // By how much the cone's measure falls as the ball shrinks, or grows as it grows by up to widest_.
    if (cone >= 0 && plane >= 0)
      return std::min({widest_, cone * distance_ / (in.along + in.across * slope_), until_plane}) / stretch_;
    const double until_cone = -cone * distance_ / (std::fabs(in.along) + in.across * widest_slope_);
    return std::max(std::min(widest_, until_cone), plane < 0 ? until_plane : 0) / stretch_;
  }

 private:
  struct Inside {
    double cone, plane, along, across;
  };
  [[gnu::noinline]] Inside inside(const ViewPosition& p) const {
    const glm::dvec3 view(p.x, p.y, p.z);
    glm::dvec3 at;
    for (int i = 0; i < 3; ++i) at[i] = rows_[i].x * view.x + rows_[i].y * view.y + rows_[i].z * view.z;
    const double along = at.x * axis_.x + at.y * axis_.y + at.z * axis_.z;
    const glm::dvec3 beside = at - along * axis_;
    const double across = std::sqrt(beside.x * beside.x + beside.y * beside.y + beside.z * beside.z);
    return {along * sin_ - across * cos_, along - tangent_, along, across};
  }

  double ball_ = 0;                // q, without what the region takes; 0: nothing is hidden
  double slack_if_useless_m_ = 0;  // of an eye so low that there is no ball
  glm::dvec3 rows_[3]{};           // from view coordinates to the stretched scene's
  glm::dvec3 axis_{0};             // from the eye to the centre, of length 1
  double stretch_ = 1, distance_ = 0, sin_ = 0, cos_ = 1, tangent_ = 0, slope_ = 0;
  // A motion after which the eye is still outside of the ball; and the cone's slope for a ball that is larger by it.
  double widest_ = 0, widest_slope_ = 0;
};

}  // namespace foreland::proto
