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
// A sphere stands far above the ground that it holds, so a wide one is seldom in the cone though its ground is. No
// ground is higher than the ceiling H, which the scene knows: so from directions that are further apart than
//   limit = acos(q/D) + acos(q/(A + g H))
// no ground is seen, and a node's ground lies in directions within g r / q of its centre's, all as chords of the unit
// ball. Either test hides a node. An eye that moves by s turns its direction by s / (D - s), and its first angle grows
// by q s / (D sqrt(D^2 - q^2)) at most.
//
// All measures shrink with a sphere that lies in another, whatever rounding does, as metric.h demands: no squares are
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
  // Of a globe above whose ceiling no ground lies.
  Horizon(const Frame& frame, double ceiling_m, const View& view, const Frustum& frustum);

  bool hidesAnything() const { return ball_ > 0; }
  [[gnu::noinline]] bool hides(const ViewPosition& p, double radius_m) const {
    if (!hidesAnything()) return false;
    const Inside in = inside(p);
    return std::min(in.cone, in.plane) >= radius_m * stretch_ || in.apart >= apartHidden(radius_m);
  }
  // How far the eye may surely move, metres, before hides() says something else; at least 0.
  [[gnu::noinline]] double slack(const ViewPosition& p, double radius_m) const {
    if (!hidesAnything()) return slack_if_useless_m_;
    const Inside in = inside(p);
    const double of_ground = in.apart - apartHidden(radius_m);
    const double ground_slack =
        std::min(widest_apart_, std::fabs(of_ground) * (of_ground < 0 ? per_apart_seen_ : per_apart_)) / stretch_;
    const double sphere_slack = slackOfSphere(in, radius_m);
    const bool is_sphere_hidden = std::min(in.cone, in.plane) >= radius_m * stretch_, is_ground_hidden = of_ground >= 0;
    if (is_sphere_hidden != is_ground_hidden) return is_sphere_hidden ? sphere_slack : ground_slack;
    return is_sphere_hidden ? std::max(sphere_slack, ground_slack) : std::min(sphere_slack, ground_slack);
  }

 private:
  struct Inside {
    double cone, plane, along, across, apart;
  };
  // How far the directions of eye and centre are apart when no ground of a sphere is seen any more.
  double apartHidden(double radius_m) const { return apart_ + per_radius_ * radius_m; }
  double slackOfSphere(const Inside& in, double radius_m) const {
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
  void limitDirections(double floor, double top, double region);
  [[gnu::noinline]] Inside inside(const ViewPosition& p) const {
    const glm::dvec3 view(p.x, p.y, p.z);
    glm::dvec3 at;
    for (int i = 0; i < 3; ++i) at[i] = rows_[i].x * view.x + rows_[i].y * view.y + rows_[i].z * view.z;
    const double along = at.x * axis_.x + at.y * axis_.y + at.z * axis_.z;
    const glm::dvec3 beside = at - along * axis_;
    const double across = std::sqrt(beside.x * beside.x + beside.y * beside.y + beside.z * beside.z);
    const glm::dvec3 centre = at - distance_ * axis_;
    const double scale = 1 / std::sqrt(centre.x * centre.x + centre.y * centre.y + centre.z * centre.z);
    const glm::dvec3 turn = scale * centre + axis_;
    return {along * sin_ - across * cos_, along - tangent_, along, across,
            std::sqrt(turn.x * turn.x + turn.y * turn.y + turn.z * turn.z)};
  }

  double ball_ = 0;                // q, without what the region takes; 0: nothing is hidden
  double slack_if_useless_m_ = 0;  // of an eye so low that there is no ball
  glm::dvec3 rows_[3]{};           // from view coordinates to the stretched scene's
  glm::dvec3 axis_{0};             // from the eye to the centre, of length 1
  double stretch_ = 1, distance_ = 0, sin_ = 0, cos_ = 1, tangent_ = 0, slope_ = 0;
  // A motion after which the eye is still outside of the ball; and the cone's slope for a ball that is larger by it.
  double widest_ = 0, widest_slope_ = 0;
  // Of directions: the limit as a chord (above 2: nothing is hidden by it), what each metre of radius adds, a motion
  // after which the region is still outside of the ball, and how far the eye may move for each part of the chord until
  // hidden ground is seen or seen ground hidden. What is stretched is in metres of stretched space.
  double apart_ = 3, per_radius_ = 0, widest_apart_ = 0, per_apart_ = 0, per_apart_seen_ = 0;
};

}  // namespace foreland::proto
