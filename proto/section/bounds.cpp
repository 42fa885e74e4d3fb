#include "proto/section/bounds.h"

#include <algorithm>
#include <cmath>

#include "proto/space/trig.h"

namespace foreland::proto {

namespace {

// Metres between samples, the widest of the scene: along the wider axis, and along the longer diagonal.
struct Spacing {
  double along, across;
};

Spacing spacingOf(const GridTopology& grid, const Frame& frame) {
  const auto length = [](const glm::dvec2& axis) { return std::sqrt(axis.x * axis.x + axis.y * axis.y); };
  const glm::dvec2 &x = frame.axis_x_m, &y = frame.axis_y_m;
  if (frame.kind == FrameKind::kPlanar) return {std::max(length(x), length(y)), std::max(length(x + y), length(x - y))};
  if (frame.kind == FrameKind::kGlobe) {  // a cube's tangents are steeper by their angle than 1.6 nowhere
    const double along = 1.61 * frame.semi_major_m / frame.face_steps;
    return {along, along * std::sqrt(2.0)};
  }
  const double first = frame.latitude0_rad, last = first + grid.maxY() * frame.latitude_step_rad;
  const bool crosses_equator = (first < 0) != (last < 0);
  const double widest = crosses_equator ? 1 : std::max(sinCos(first).cos, sinCos(last).cos);
  const glm::dvec2 steps =
      frame.semi_major_m * glm::dvec2(std::fabs(frame.longitude_step_rad) * widest, std::fabs(frame.latitude_step_rad));
  return {std::max(steps.x, steps.y), length(steps)};
}

}  // namespace

SphereLevels::SphereLevels(const GridTopology& grid, const Frame& frame) {
  const Spacing spacing = spacingOf(grid, frame);
  constexpr double kPad_m = 2e-5;  // what saturation adds to each
  double radius = spacing.along + kPad_m;
  for (int level = grid.maxLevel(); level >= 1; --level) {
    const double s = std::ldexp(1.0, static_cast<int>(grid.shape().root_log2) - 1 - level / 2);
    // The way to a child, as bounds.h of the terrain has it: side nodes' children are half a step away both ways.
    if (level < grid.maxLevel()) radius += kPad_m + (level & 1 ? 0.5 * s * spacing.across : s * spacing.along);
    flat_m_[static_cast<size_t>(level)] = bounds_detail::floatAbove(radius);
  }
}

QuantisedRadius SphereLevels::roundUp(int level, double radius_m) const {
  const double factor = radius_m / static_cast<double>(flat_m_[static_cast<size_t>(level)]);
  int c = factor <= 1 ? 0 : (bounds_detail::eighthsAbove(bounds_detail::floatAbove(factor)) + 1) / 2;
  c = std::clamp(c, 0, QuantisedRadius::kMax);
  while (c < QuantisedRadius::kMax && static_cast<double>(this->radius(level, {static_cast<uint8_t>(c)})) < radius_m)
    ++c;
  return {static_cast<uint8_t>(c)};
}

}  // namespace foreland::proto
