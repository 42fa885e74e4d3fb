#include "server/occlusion/block_tops.h"

#include <algorithm>
#include <limits>

namespace foreland::server {

namespace {

using proto::NodeId;

constexpr int32_t kNone = std::numeric_limits<int32_t>::min() / 2;

struct Squares {
  uint32_t columns, rows;
  std::vector<int32_t> value;

  Squares(uint32_t c, uint32_t r, int32_t all) : columns(c), rows(r), value(size_t{c} * r, all) {}
  void raise(int64_t i, int64_t j, int32_t to) {
    if (i < 0 || j < 0 || i >= columns || j >= rows) return;
    int32_t& v = value[static_cast<size_t>(j) * columns + static_cast<size_t>(i)];
    v = std::max(v, to);
  }
  int32_t at(int64_t i, int64_t j) const {
    if (i < 0 || j < 0 || i >= columns || j >= rows) return kNone;
    return value[static_cast<size_t>(j) * columns + static_cast<size_t>(i)];
  }
};

// The largest height in each square of side 2^(scale + 1), its border included.
Squares largestHeights(const Hierarchy& hierarchy, uint32_t scale) {
  const proto::GridTopology& grid = hierarchy.grid();
  const proto::DenseNodes table = hierarchy.table();
  const uint32_t side_log2 = scale + 1;
  Squares largest(grid.maxX() >> side_log2, grid.maxY() >> side_log2, kNone);
  for (uint32_t y = 0; y <= grid.maxY(); ++y)
    for (uint32_t x = 0; x <= grid.maxX(); ++x) {
      const int32_t height = table.height(NodeId::at(x, y));
      const int64_t i = x >> side_log2, j = y >> side_log2, mask = (int64_t{1} << side_log2) - 1;
      const bool on_column = (x & mask) == 0, on_row = (y & mask) == 0;
      largest.raise(i, j, height);
      if (on_column) largest.raise(i - 1, j, height);
      if (on_row) largest.raise(i, j - 1, height);
      if (on_column && on_row) largest.raise(i - 1, j - 1, height);
    }
  return largest;
}

Squares coarser(const Squares& fine) {
  Squares coarse(fine.columns / 2, fine.rows / 2, kNone);
  for (uint32_t j = 0; j < fine.rows; ++j)
    for (uint32_t i = 0; i < fine.columns; ++i) coarse.raise(i / 2, j / 2, fine.at(i, j));
  return coarse;
}

}  // namespace

BlockTops::BlockTops(const Hierarchy& hierarchy, size_t max_squares) {
  const proto::GridTopology& grid = hierarchy.grid();
  const uint32_t scales = grid.shape().root_log2;
  while (finest_ + 1 < scales && size_t{grid.maxX() >> (finest_ + 1)} * (grid.maxY() >> (finest_ + 1)) > max_squares)
    ++finest_;
  Squares highest = largestHeights(hierarchy, finest_);
  for (uint32_t scale = finest_; scale < scales; ++scale) {
    if (scale > finest_) highest = coarser(highest);
    levels_.push_back({highest.columns, highest.rows, highest.value});
  }
}

size_t BlockTops::bytes() const {
  size_t bytes = 0;
  for (const Level& level : levels_) bytes += level.tops.capacity() * sizeof(int32_t);
  return bytes;
}

}  // namespace foreland::server
