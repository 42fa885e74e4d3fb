// A unit normal in four bytes: x, y and z as signed bytes, then 0. Packing and unpacking turns a normal by less than
// half a degree.
#pragma once

#include <cmath>
#include <cstdint>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>

namespace foreland::client {

// `n` is of unit length; a vector of no length packs as straight up.
inline uint32_t packNormal(const glm::dvec3& n) {
  // A conversion rounds towards zero, so it takes a positive number to round to the nearest.
  const auto byte = [](double v) { return static_cast<uint32_t>(static_cast<int32_t>(v * 127 + 256.5)) & 0xff; };
  const uint32_t packed = byte(n.x) | byte(n.y) << 8 | byte(n.z) << 16;
  return packed != 0 ? packed : 127u << 16;
}

inline glm::dvec3 unpackNormal(uint32_t packed) {
  const auto component = [&](int shift) { return static_cast<double>(static_cast<int8_t>(packed >> shift)); };
  const glm::dvec3 n(component(0), component(8), component(16));
  return n / glm::length(n);
}

}  // namespace foreland::client
