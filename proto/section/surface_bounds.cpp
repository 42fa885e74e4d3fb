#include "proto/section/surface_bounds.h"

#include <algorithm>

namespace foreland::proto {

CompactBound CompactBound::roundUp(double metres) {
  const auto nearest = static_cast<float>(metres);
  const uint32_t above = std::bit_cast<uint32_t>(nearest) + (nearest < metres ? 1 : 0);
  return {static_cast<uint16_t>((above + 0x7fff) >> 15)};
}

CompactNormal CompactNormal::pack(const glm::dvec3& n) {
  const double sum = std::fabs(n.x) + std::fabs(n.y) + std::fabs(n.z);
  double u = n.x / sum, v = n.y / sum;
  if (n.z < 0) {
    const double folded = (1 - std::fabs(v)) * std::copysign(1.0, u);
    v = (1 - std::fabs(u)) * std::copysign(1.0, v);
    u = folded;
  }
  const auto round = [](double t) { return static_cast<int16_t>(std::lround(std::clamp(t, -1.0, 1.0) * 32767)); };
  return {round(u), round(v)};
}

CompactShare CompactShare::roundUp(double share) {
  if (!(share < 1)) return {255};
  return {static_cast<uint8_t>(std::min(255.0, std::ceil(std::sqrt(share) * 255 * (1 + 1e-12))))};
}

}  // namespace foreland::proto
