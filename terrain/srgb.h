// The transfer function of sRGB (IEC 61966-2-1), for shares from 0 to 1; what lies beyond counts as 0 or 1. Pure; any
// thread.
#pragma once

#include <algorithm>
#include <cmath>

namespace foreland::terrain {

// 0 also for what is no number.
inline double srgbOfLinear(double linear) {
  if (!(linear > 0)) return 0;
  const double c = std::min(linear, 1.0);
  return c <= 0.0031308 ? 12.92 * c : 1.055 * std::pow(c, 1 / 2.4) - 0.055;
}

inline double linearOfSrgb(double srgb) {
  const double c = std::clamp(srgb, 0.0, 1.0);
  return c <= 0.04045 ? c / 12.92 : std::pow((c + 0.055) / 1.055, 2.4);
}

}  // namespace foreland::terrain
