// Where points appear on a screen, and how large texels on the ground do: by projecting them, without any bound.
#pragma once

#include <cmath>
#include <glm/gtc/quaternion.hpp>
#include <optional>

#include "proto/space/view.h"

namespace foreland::test {

// In pixels from the middle; nothing if it is out of view.
inline std::optional<glm::dvec2> project(const proto::View& view, const glm::dvec3& p) {
  const glm::dvec3 q = glm::conjugate(view.pose.orientation) * (p - view.pose.eye);
  if (q.z > -0.1) return std::nullopt;
  const double focal = 0.5 * view.lens.height_px / std::tan(0.5 * view.lens.vertical_fov_rad);
  const glm::dvec2 at = glm::dvec2(q) * (focal / -q.z);
  if (std::abs(at.x) > 0.5 * view.lens.width_px || std::abs(at.y) > 0.5 * view.lens.height_px) return std::nullopt;
  return at;
}

// In pixels: the root of the area of a texel of `side` sample intervals at a lattice position, where `positionAt(x, y)`
// is the ground's; nothing if it is out of view or seen from behind.
template <class PositionAt>
std::optional<double> texelOnScreen(const PositionAt& positionAt, const proto::View& view, double x, double y,
                                    double side, double step = 0.1) {
  const auto a = project(view, positionAt(x, y)), b = project(view, positionAt(x + step, y)),
             c = project(view, positionAt(x, y + step));
  if (!a || !b || !c) return std::nullopt;
  const glm::dvec2 u = (*b - *a) / step, v = (*c - *a) / step;
  const double area = u.x * v.y - u.y * v.x;
  if (area <= 0) return std::nullopt;
  return side * std::sqrt(area);
}

}  // namespace foreland::test
