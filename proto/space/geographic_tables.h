// The trigonometry of a geographic frame, computed once for each lattice row and column: all that
// FrameTransform::toScene needs of a lattice position besides its height. Empty for a planar frame. Immutable once
// made; any thread. Memory: 16 bytes per column and 24 per row.
#pragma once

#include <cstdint>
#include <vector>

#include "proto/space/frame.h"

namespace foreland::proto {

struct GeographicTables {
  // For lattice positions 0..max_x, 0..max_y.
  GeographicTables(const FrameTransform& transform, uint32_t max_x, uint32_t max_y);

  std::vector<FrameTransform::Row> rows;
  std::vector<FrameTransform::Column> columns;
};

}  // namespace foreland::proto
