// The quantised samples of the true surface, which bounds are computed from. A view; immutable; any thread.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "proto/section/bounds.h"

namespace foreland::terrain {

struct Heights {
  std::span<const int32_t> quanta;  // row by row from the south
  uint32_t width = 0;
  uint32_t height = 0;

  const int32_t* row(uint32_t y) const { return quanta.data() + static_cast<size_t>(y) * width; }
  // The sample at (x, y); outside the data, the nearest one.
  int32_t clamped(uint32_t x, uint32_t y) const { return row(std::min(y, height - 1))[std::min(x, width - 1)]; }
};

// A height in the nearest whole number of quanta; nothing if it does not fit a record.
inline std::optional<int32_t> quantised(float metres, double height_quantum_m) {
  const double quanta = std::nearbyint(metres / height_quantum_m);
  if (!(std::fabs(quanta) < proto::kMaxHeight)) return std::nullopt;
  return static_cast<int32_t>(quanta);
}

}  // namespace foreland::terrain
