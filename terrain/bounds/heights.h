// The quantised samples of the true surface, which bounds are computed from. A view; immutable; any thread.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>

namespace foreland::terrain {

struct Heights {
  std::span<const int32_t> quanta;  // row by row from the south
  uint32_t width = 0;
  uint32_t height = 0;

  const int32_t* row(uint32_t y) const { return quanta.data() + static_cast<size_t>(y) * width; }
  // The sample at (x, y); outside the data, the nearest one.
  int32_t clamped(uint32_t x, uint32_t y) const { return row(std::min(y, height - 1))[std::min(x, width - 1)]; }
};

}  // namespace foreland::terrain
