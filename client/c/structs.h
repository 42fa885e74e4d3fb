// Structs that cross the C interface, by the size that their host knows them with. Pure; any thread.
#pragma once

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <glm/vec3.hpp>
#include <type_traits>

namespace foreland::client {

// Too small for any version of a struct: its size was not set.
template <class T>
bool hasSize(const T* value) {
  return value != nullptr && value->size >= 2 * sizeof(uint32_t);
}

// What the host gave; the rest is 0.
template <class T>
T readStruct(const T& given) {
  static_assert(std::is_trivially_copyable_v<T>);
  T out{};
  std::memcpy(&out, &given, std::min<size_t>(given.size, sizeof(T)));
  return out;
}

// As much as the host has room for.
template <class T>
void writeStruct(T value, T* out) {
  static_assert(std::is_trivially_copyable_v<T>);
  value.size = out->size;
  std::memcpy(out, &value, std::min<size_t>(out->size, sizeof(T)));
}

inline glm::dvec3 vectorOf(const double v[3]) { return {v[0], v[1], v[2]}; }
inline void put(const glm::dvec3& v, double out[3]) { out[0] = v.x, out[1] = v.y, out[2] = v.z; }

}  // namespace foreland::client
