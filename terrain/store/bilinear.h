// What lies between the samples of a lattice. Pure; any thread.
#pragma once

#include <algorithm>
#include <cstdint>

namespace foreland::terrain {

// A quantity at a position from (0, 0) to (width - 1, height - 1), both at least 2: bilinear between what at(x, y) says
// of the four samples around it.
template <class At>
double bilinear(uint32_t width, uint32_t height, double x, double y, const At& at) {
  const uint32_t x0 = std::min(static_cast<uint32_t>(x), width - 2),
                 y0 = std::min(static_cast<uint32_t>(y), height - 2);
  const double u = x - x0, v = y - y0;
  const auto sample = [&](uint32_t dx, uint32_t dy) -> double { return at(x0 + dx, y0 + dy); };
  const double south = sample(0, 0) + u * (sample(1, 0) - sample(0, 0)),
               north = sample(0, 1) + u * (sample(1, 1) - sample(0, 1));
  return south + v * (north - south);
}

}  // namespace foreland::terrain
