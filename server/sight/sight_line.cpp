#include "server/sight/sight_line.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

namespace foreland::server {

namespace {

// Of a line that is steeper than this the horizontal part, and with it what it sags, is nothing.
constexpr double kUpright = 1e-6;

glm::dvec3 anyAcross(const glm::dvec3& unit) {
  const glm::dvec3 axis = std::fabs(unit.x) < 0.5 ? glm::dvec3(1, 0, 0) : glm::dvec3(0, 1, 0);
  return glm::normalize(glm::cross(unit, axis));
}

}  // namespace

SightLine::SightLine(const proto::FrameTransform& transform, const glm::dvec3& from, const glm::dvec3& to,
                     double refraction)
    : from_(from), way_(to - from), up_(transform.upAt(0.5 * (from + to))), length_m_(glm::distance(from, to)) {
  ends_ = length_m_ > 0 ? std::min(0.5, kEnds_m / length_m_) : 0.5;
  const glm::dvec3 level = way_ - glm::dot(way_, up_) * up_;
  const double distance_m = glm::length(level);
  glm::dvec3 left, above = up_;
  if (distance_m > kUpright * length_m_) {
    const bool is_planar = transform.frame().kind == proto::FrameKind::kPlanar;
    const double share = is_planar ? 1 - refraction : -refraction;
    sag_m_ = share * distance_m * distance_m / (8 * kEarthRadius_m);
    left = glm::cross(up_, level) / distance_m;
  } else {
    const glm::dvec3 along = length_m_ > 0 ? way_ / length_m_ : up_;
    left = anyAcross(along);
    above = glm::cross(along, left);
  }
  const glm::dvec3 along = length_m_ > 0 ? way_ : glm::cross(left, above);
  to_line_ = glm::inverse(glm::dmat3(along, left, above));
}

// Both shares at which the path crosses a plane, the lower first; not finite where it does not.
std::array<double, 2> SightLine::meetPlane(const glm::dvec3& normal, const glm::dvec3& point) const {
  const double bend = 4 * sag_m_ * glm::dot(normal, up_), slope = glm::dot(normal, way_) - bend,
               height = glm::dot(normal, from_ - point);
  const double q = -0.5 * (slope + std::copysign(std::sqrt(slope * slope - 4 * bend * height), slope));
  const double one = q / bend, other = height / q;  // a straight path has no `one`
  return one < other ? std::array{one, other} : std::array{other, one};
}

// As far as rounding lets one tell: between two points of one triangle it is noise where a path would meet it.
bool SightLine::isInPlane(const glm::dvec3& unit_normal, const glm::dvec3& point) const {
  const auto isNear = [](double metres) { return std::fabs(metres) <= kTouch_m; };
  return isNear(glm::dot(unit_normal, from_ - point)) && isNear(glm::dot(unit_normal, from_ + way_ - point)) &&
         isNear(sag_m_ * glm::dot(unit_normal, up_));
}

std::optional<double> SightLine::meet(const std::array<glm::dvec3, 3>& t, const std::array<Aside, 3>& asides) const {
  const auto [first, last] = std::minmax({asides[0].share, asides[1].share, asides[2].share});
  if (!isMet(asides, touchMetres(first, last))) return std::nullopt;
  const glm::dvec3 u = t[1] - t[0], v = t[2] - t[0], n = glm::cross(u, v);
  const double area2 = glm::dot(n, n);
  if (area2 == 0 || isInPlane(n / std::sqrt(area2), t[0])) return std::nullopt;
  const double lack = kTouch_m * (glm::length(u) + glm::length(v)) / std::sqrt(area2);  // of a corner's weight
  for (const double share : meetPlane(n, t[0])) {
    if (!(share > firstShare() && share < lastShare())) continue;
    const glm::dvec3 p = at(share) - t[0];
    const double at_u = glm::dot(glm::cross(p, v), n) / area2, at_v = glm::dot(glm::cross(u, p), n) / area2;
    if (at_u >= -lack && at_v >= -lack && at_u + at_v <= 1 + lack) return share;
  }
  return std::nullopt;
}

}  // namespace foreland::server
