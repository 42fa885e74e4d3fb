#include "terrain/imagery/normal_cone.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

namespace foreland::terrain {

namespace {

constexpr double kUnit = 1.57079632679489662 / 255;  // radians of half_angle
constexpr double kRounding = 1e-7;                   // radians; more than acos and the sums below lose

glm::dvec3 unit(const std::array<int8_t, 3>& axis) { return glm::normalize(glm::dvec3(axis[0], axis[1], axis[2])); }
double angleBetween(const glm::dvec3& a, const glm::dvec3& b) {
  return std::atan2(glm::length(glm::cross(a, b)), glm::dot(a, b));
}
NormalCone coneWith(const std::array<int8_t, 3>& axis, double half_angle_rad) {
  const double units = std::ceil((half_angle_rad + kRounding) / kUnit);
  if (!(units <= 255)) return NormalCone::everything();
  return {axis, static_cast<uint8_t>(std::max(units, 0.0))};
}

}  // namespace

glm::dvec3 NormalCone::unitAxis() const { return unit(axis); }

bool NormalCone::holds(const glm::dvec3& n) const {
  return isEverything() || angleBetween(unitAxis(), n) <= half_angle * kUnit;
}

bool NormalCone::holds(const NormalCone& other) const {
  if (isEverything()) return true;
  if (other.isEverything()) return false;
  return angleBetween(unitAxis(), other.unitAxis()) + other.half_angle * kUnit <= half_angle * kUnit;
}

std::array<int8_t, 3> quantisedAxis(const glm::dvec3& middle) {
  const glm::dvec3 n = glm::normalize(middle) * 127.0;
  const auto rounded = [](double v) { return static_cast<int8_t>(std::lround(v)); };
  return {rounded(n.x), rounded(n.y), rounded(n.z)};
}

NormalCone coneOf(const std::array<int8_t, 3>& axis, double min_cosine) {
  return coneWith(axis, std::acos(std::clamp(min_cosine, -1.0, 1.0)));
}

NormalCone unionOf(std::span<const NormalCone> cones) {
  glm::dvec3 sum(0);
  for (const NormalCone& c : cones) {
    if (c.isEverything()) return c;
    sum += c.unitAxis();
  }
  if (!(glm::length(sum) > 1e-3)) return NormalCone::everything();
  const auto axis = quantisedAxis(sum);
  double half_angle = 0;
  for (const NormalCone& c : cones)
    half_angle = std::max(half_angle, angleBetween(unit(axis), c.unitAxis()) + c.half_angle * kUnit);
  return coneWith(axis, half_angle);
}

}  // namespace foreland::terrain
