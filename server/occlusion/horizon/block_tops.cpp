#include "server/occlusion/horizon/block_tops.h"

#include <algorithm>
#include <limits>

#include "server/section/height_bounds.h"

namespace foreland::server {

namespace {

using proto::NodeId;

// Reads the heights of a square, its borders included.
BlockTops::Square squareAt(const HeightBounds& bounds, uint32_t x0, uint32_t y0, uint32_t side) {
  const auto height = [&](uint32_t x, uint32_t y) { return bounds.highest(NodeId::at(x0 + x, y0 + y)); };
  const auto corner = [&](uint32_t x, uint32_t y) { return static_cast<float>(height(x * side, y * side)); };
  BlockTops::Square s{height(0, 0), height(0, 0), std::numeric_limits<float>::lowest(),
                      0.25f * (corner(1, 0) + corner(1, 1) - corner(0, 0) - corner(0, 1)),
                      0.25f * (corner(0, 1) + corner(1, 1) - corner(0, 0) - corner(1, 0))};
  const float per_sample = 2.0f / static_cast<float>(side);
  for (uint32_t y = 0; y <= side; ++y)
    for (uint32_t x = 0; x <= side; ++x) {
      const int32_t h = height(x, y);
      s.top = std::max(s.top, h);
      s.bottom = std::min(s.bottom, bounds.lowest(NodeId::at(x0 + x, y0 + y)));
      s.height = std::max(s.height, static_cast<float>(h) - s.tilt_x * (static_cast<float>(x) * per_sample - 1) -
                                        s.tilt_y * (static_cast<float>(y) * per_sample - 1));
    }
  return s;
}

}  // namespace

BlockTops::BlockTops(const Hierarchy& hierarchy, size_t max_squares) {
  const proto::GridTopology& grid = hierarchy.grid();
  const HeightBounds bounds(hierarchy);
  const uint32_t scales = grid.shape().root_log2;
  while (finest_ + 1 < scales && size_t{grid.maxX() >> (finest_ + 1)} * (grid.maxY() >> (finest_ + 1)) > max_squares)
    ++finest_;
  for (uint32_t scale = finest_; scale < scales; ++scale) {
    const uint32_t side = 2u << scale;
    Level level{grid.maxX() / side, grid.maxY() / side, {}};
    level.squares.reserve(size_t{level.columns} * level.rows);
    for (uint32_t j = 0; j < level.rows; ++j)
      for (uint32_t i = 0; i < level.columns; ++i) level.squares.push_back(squareAt(bounds, i * side, j * side, side));
    levels_.push_back(std::move(level));
  }
}

size_t BlockTops::bytes() const {
  size_t bytes = 0;
  for (const Level& level : levels_) bytes += level.squares.capacity() * sizeof(Square);
  return bytes;
}

}  // namespace foreland::server
