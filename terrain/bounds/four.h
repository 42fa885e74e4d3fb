// Four doubles at a time, by the compiler's vector types: no intrinsics, any processor, the same results as for one
// double at a time.
#pragma once

#include <algorithm>
#include <cstdint>
#include <cstring>

namespace foreland::terrain {

using Four = double __attribute__((vector_size(32)));
using FourInts = int32_t __attribute__((vector_size(16)));
inline constexpr Four kZeroToThree{0, 1, 2, 3};

inline Four loadFour(const int32_t* values) {
  FourInts four;
  std::memcpy(&four, values, sizeof(four));
  return __builtin_convertvector(four, Four);
}
inline Four loadFour(const double* values) {
  Four four;
  std::memcpy(&four, values, sizeof(four));
  return four;
}
inline void storeFour(double* values, Four four) { std::memcpy(values, &four, sizeof(four)); }
inline Four larger(Four a, Four b) { return a > b ? a : b; }
inline Four magnitude(Four v) { return larger(v, -v); }
inline double largest(Four v) { return std::max(std::max(v[0], v[1]), std::max(v[2], v[3])); }

}  // namespace foreland::terrain
