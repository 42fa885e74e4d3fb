// A unit normal in four bytes: x, y and z as signed bytes, then 0. Packing and unpacking turns a normal by less than
// half a degree.
#pragma once

#include <cmath>
#include <cstdint>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>

namespace foreland::client {

// `n` need not be of unit length; a vector of no length packs as straight up.
inline uint32_t packNormal(const glm::dvec3& n) {
  const double length = std::sqrt(glm::dot(n, n));
  const auto byte = [&](double v) {
    return static_cast<uint32_t>(static_cast<uint8_t>(static_cast<int32_t>(std::floor(v / length * 127 + 0.5))));
  };
  return length > 0 ? byte(n.x) | byte(n.y) << 8 | byte(n.z) << 16 : 127u << 16;
}

inline glm::dvec3 unpackNormal(uint32_t packed) {
  const auto component = [&](int shift) { return static_cast<double>(static_cast<int8_t>(packed >> shift)); };
  const glm::dvec3 n(component(0), component(8), component(16));
  return n / glm::length(n);
}

}  // namespace foreland::client
