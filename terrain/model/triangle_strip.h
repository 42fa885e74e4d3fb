// Strips of triangles: each vertex from the third on makes a triangle with the two before it, every second one turned
// round. A negative number ends a strip and begins another; a triangle that names a vertex twice only joins strips.
// Pure.
#pragma once

#include <array>
#include <span>
#include <utility>

#include "base/result.h"

namespace foreland::terrain {

// Calls `add` with the three numbers of each triangle, until one of its answers is not ok. O(numbers).
template <class Add>
Status eachTriangleOfStrip(std::span<const double> numbers, Add&& add) {
  size_t first = 0;
  for (size_t i = 0; i < numbers.size(); ++i) {
    if (!(numbers[i] >= 0)) first = i + 1;
    if (i < first + 2) continue;
    std::array<double, 3> triangle{numbers[i - 2], numbers[i - 1], numbers[i]};
    if ((i - first) % 2 == 1) std::swap(triangle[0], triangle[1]);
    if (triangle[0] == triangle[1] || triangle[1] == triangle[2] || triangle[2] == triangle[0]) continue;
    if (Status status = add(std::span<const double>(triangle)); !status.ok()) return status;
  }
  return {};
}

}  // namespace foreland::terrain
