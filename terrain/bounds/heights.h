// The quantised samples of the true surface, which bounds are computed from: all of them, or those of a window, of
// which whoever asks for others gets what is not there. A view; immutable; any thread.
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
  uint32_t width = 0;               // of all of the surface
  uint32_t height = 0;
  uint32_t first_x = 0, first_y = 0;  // the sample that quanta[0] is
  uint32_t stride = 0;                // from row to row of quanta; 0: width

  // The sample (0, y), where that is in the window; others are as far from it as they are from each other.
  const int32_t* row(uint32_t y) const {
    return quanta.data() + static_cast<ptrdiff_t>(static_cast<size_t>(y - first_y) * (stride ? stride : width)) -
           static_cast<ptrdiff_t>(first_x);
  }
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
