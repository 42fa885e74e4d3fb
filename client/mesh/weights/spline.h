// The curve of a uniform B-spline over one interval, by its value at the interval's end and two controls between
// (Bezier's): what a mesh of order 2 or 3 is made of (P, equation 1; blend.h). The value at the beginning is that at
// the end of the interval before. Of values that are equal every result is that value, exactly. Pure; any thread.
#pragma once

#include <array>
#include <cstdint>

namespace foreland::client {

// `at(i)` is the value at the keyframe i before the newest one.
template <class At>
double splineEnd(uint32_t order, const At& at) {
  if (order == 1) return at(0);
  return order == 2 ? (at(0) + at(1)) / 2 : (at(0) + 4 * at(1) + at(2)) / 6;
}

// `from` and `to` are the curve's ends.
template <class At>
std::array<double, 2> splineControls(uint32_t order, double from, double to, const At& at) {
  if (order == 1) return {(2 * from + to) / 3, (from + 2 * to) / 3};
  if (order == 2) return {(from + 2 * at(1)) / 3, (2 * at(1) + to) / 3};
  return {(2 * at(2) + at(1)) / 3, (at(2) + 2 * at(1)) / 3};
}

}  // namespace foreland::client
