// A unit normal as signed bytes x, y, z, 0; straight up for one of no length. There and back turns it by less than half
// a degree.
#pragma once

#include <cmath>
#include <cstdint>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>

namespace foreland::client {

inline uint32_t packNormal(const glm::dvec3& n) {
  const double length = std::sqrt(glm::dot(n, n));
  const auto byte = [&](double v) {
    return static_cast<uint32_t>(static_cast<uint8_t>(static_cast<int32_t>(std::floor(v / length * 127 + 0.5))));
  };
  return length > 0 ? byte(n.x) | byte(n.y) << 8 | byte(n.z) << 16 : 127u << 16;
}

inline glm::dvec3 unpackNormal(uint32_t packed) {
  const auto part = [&](int shift) { return static_cast<double>(static_cast<int8_t>(packed >> shift)); };
  const glm::dvec3 n(part(0), part(8), part(16));
  return n / glm::length(n);
}

}  // namespace foreland::client
