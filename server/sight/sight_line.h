// A line of sight between two points of the scene frame, as light goes, and whether a triangle hides it. Light's path
// is a parabola through both ends that sags from their chord:
//
//   planar scenes      down by (1 - k) s (D - s) / 2R at s of the horizontal distance D: the map is flat, so the earth's
//                      curvature (radius R) is in the line instead
//   other scenes       up by k s (D - s) / 2R: the scene is as round as the earth is, so a straight line is exact
//
// with k the coefficient of refraction: 0 for straight lines, 1/7 for light in usual air, which gdal_viewshed has as
// `-cc 0.85714`. Everything is computed in doubles. A triangle's corners are taken to coordinates in which the path is
// an axis, where most triangles are seen to be missed; for the others the parabola is met with the triangle's plane. A
// path within kTouch_m of an edge meets it, so nothing passes between triangles.
//
// Pure values; any thread.
#pragma once

#include <array>
#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>
#include <optional>

#include "proto/space/frame.h"

namespace foreland::server {

class SightLine {
 public:
  static constexpr double kEarthRadius_m = 6'371'008.8;  // the mean one
  // What lies so near to either end hides nothing: an end may stand on what it stands on.
  static constexpr double kEnds_m = 1e-3;
  static constexpr double kTouch_m = 1e-7;

  SightLine(const proto::FrameTransform& transform, const glm::dvec3& from, const glm::dvec3& to, double refraction);

  // How far the path may be from the edges of a triangle whose corners are as far along as these, if they are taken as
  // straight in aside()'s coordinates.
  double touchMetres(double first_share, double last_share) const {
    const double along = last_share - first_share;
    return kTouch_m + sagMetres() * along * along;
  }
  // A share of the way: 0 at `from`, 1 at `to`.
  glm::dvec3 at(double share) const { return from_ + share * way_ - (sagAt(share) * up_); }
  double lengthMetres() const { return length_m_; }
  const glm::dvec3& from() const { return from_; }
  const glm::dvec3& way() const { return way_; }  // to the other end
  const glm::dvec3& up() const { return up_; }    // at the chord's middle
  double sag() const { return sag_m_; }           // of the path's middle below the chord's, metres
  // Of its middle from the chord, either way.
  double sagMetres() const { return sag_m_ < 0 ? -sag_m_ : sag_m_; }
  // The shares between which it can be hidden.
  double firstShare() const { return ends_; }
  double lastShare() const { return 1 - ends_; }

  // How far along the line a point is, and how far aside and above of it; share, metres, metres.
  struct Aside {
    double share, left_m, above_m;
  };
  Aside aside(const glm::dvec3& point) const {
    const glm::dvec3 p = to_line_ * (point - from_);
    return {p.x, p.y, p.z + sagAt(p.x)};
  }

  // Where it meets a triangle, whose corners are also given as aside() tells them: the first share of its way within
  // its ends. Nothing if it passes by, or in the triangle's plane.
  std::optional<double> meet(const std::array<glm::dvec3, 3>& corners, const std::array<Aside, 3>& asides) const;

 private:
  double sagAt(double share) const { return 4 * sag_m_ * share * (1 - share); }
  bool isInPlane(const glm::dvec3& unit_normal, const glm::dvec3& point) const;
  std::array<double, 2> meetPlane(const glm::dvec3& normal, const glm::dvec3& point) const;

  glm::dvec3 from_, way_, up_;
  glm::dmat3 to_line_;
  double length_m_, sag_m_ = 0, ends_;
};

// Whether the axis, on which `left_m` and `above_m` are 0, passes through a triangle that is widened by `touch_m`.
inline bool isMet(const std::array<SightLine::Aside, 3>& t, double touch_m) {
  // Twice the signed area that the axis makes with an edge, and how much it may lack.
  const auto edge = [](const SightLine::Aside& p, const SightLine::Aside& q) {
    return p.left_m * q.above_m - p.above_m * q.left_m;
  };
  const auto lack = [touch_m](const SightLine::Aside& p, const SightLine::Aside& q) {
    const double dx = p.left_m - q.left_m, dy = p.above_m - q.above_m;
    return touch_m * ((dx < 0 ? -dx : dx) + (dy < 0 ? -dy : dy));
  };
  const double a = edge(t[1], t[2]), b = edge(t[2], t[0]), c = edge(t[0], t[1]), sign = a + b + c < 0 ? -1 : 1;
  return sign * a >= -lack(t[1], t[2]) && sign * b >= -lack(t[2], t[0]) && sign * c >= -lack(t[0], t[1]);
}

}  // namespace foreland::server
