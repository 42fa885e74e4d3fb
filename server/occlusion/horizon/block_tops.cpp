#include "server/occlusion/horizon/block_tops.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "server/section/height_bounds.h"
#include "terrain/store/flat_squares.h"

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

// The squares of one scale of ground that is fine in places, from its flat squares one by one. What is flat over a
// square has its extremes at its corners, but heights between nodes are rounded: by a quantum more or less it holds.
class SquaresOfScale {
 public:
  SquaresOfScale(const terrain::Scene& scene, uint32_t scale)
      : side_log2_(scale + 1),
        columns_(scene.grid().maxX() >> side_log2_),
        rows_(scene.grid().maxY() >> side_log2_),
        last_x_(scene.grid().shape().samples_x - 1),
        last_y_(scene.grid().shape().samples_y - 1) {
    const auto corner = [&](uint32_t i, uint32_t j) {
      return scene.height(NodeId::at(std::min(i << side_log2_, last_x_), std::min(j << side_log2_, last_y_)));
    };
    std::vector<int32_t> south, north(size_t{columns_} + 1);
    for (uint32_t i = 0; i <= columns_; ++i) north[i] = corner(i, 0);
    squares_.reserve(size_t{columns_} * rows_);
    for (uint32_t j = 0; j < rows_; ++j) {
      south.swap(north);
      north.resize(south.size());
      for (uint32_t i = 0; i <= columns_; ++i) north[i] = corner(i, j + 1);
      for (uint32_t i = 0; i < columns_; ++i)
        squares_.push_back(between(south[i], south[i + 1], north[i], north[i + 1]));
    }
  }

  void add(uint32_t x, uint32_t y, int32_t height) {
    // A point on a side is a corner of the flat squares on both of its sides, or lies between such corners.
    for (uint32_t j = first(y); j <= y >> side_log2_ && j < rows_; ++j)
      for (uint32_t i = first(x); i <= x >> side_log2_ && i < columns_; ++i) {
        BlockTops::Square& s = squares_[size_t{j} * columns_ + i];
        const float to_x = share(x - (i << side_log2_)), to_y = share(y - (j << side_log2_));
        include(s, height, to_x, to_y);
      }
  }

  uint32_t columns() const { return columns_; }
  uint32_t rows() const { return rows_; }
  std::vector<BlockTops::Square> take() { return std::move(squares_); }

 private:
  static BlockTops::Square between(int32_t sw, int32_t se, int32_t nw, int32_t ne) {
    const auto f = [](int32_t height) { return static_cast<float>(height); };
    BlockTops::Square s{sw, sw, std::numeric_limits<float>::lowest(), 0.25f * (f(se) + f(ne) - f(sw) - f(nw)),
                        0.25f * (f(nw) + f(ne) - f(sw) - f(se))};
    include(s, sw, -1, -1), include(s, se, 1, -1), include(s, nw, -1, 1), include(s, ne, 1, 1);
    return s;
  }
  static void include(BlockTops::Square& s, int32_t height, float to_x, float to_y) {
    s.top = std::max(s.top, height + 1);
    s.bottom = std::min(s.bottom, height - 1);
    s.height = std::max(s.height, static_cast<float>(height + 1) - s.tilt_x * to_x - s.tilt_y * to_y);
  }
  uint32_t first(uint32_t at) const { return (at - std::min(at, 1u)) >> side_log2_; }
  float share(uint32_t along) const {
    return static_cast<float>(along) * std::ldexp(2.0f, -static_cast<int>(side_log2_)) - 1;
  }

  uint32_t side_log2_, columns_, rows_, last_x_, last_y_;
  std::vector<BlockTops::Square> squares_;
};

}  // namespace

BlockTops::BlockTops(const Hierarchy& hierarchy, size_t max_squares) {
  if (hierarchy.scene().isSparse()) {
    addSparse(hierarchy.scene(), std::min(max_squares, kMostOfSparse));
    return;
  }
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

void BlockTops::addSparse(const terrain::Scene& scene, size_t max_squares) {
  const proto::GridTopology& grid = scene.grid();
  const uint32_t scales = grid.shape().root_log2;
  while (finest_ + 1 < scales && size_t{grid.maxX() >> (finest_ + 1)} * (grid.maxY() >> (finest_ + 1)) > max_squares)
    ++finest_;
  std::vector<SquaresOfScale> of_scales;
  for (uint32_t scale = finest_; scale < scales; ++scale) of_scales.emplace_back(scene, scale);
  terrain::FlatSquares(grid, scene.pages()).forEach([&](uint32_t x, uint32_t y, uint32_t side) {
    for (uint32_t k = 0; k < 4; ++k) {
      const uint32_t at_x = x + side * (k % 2), at_y = y + side * (k / 2);
      const int32_t height = scene.height(NodeId::at(at_x, at_y));
      for (SquaresOfScale& of_scale : of_scales) of_scale.add(at_x, at_y, height);
    }
  });
  for (SquaresOfScale& of_scale : of_scales) levels_.push_back({of_scale.columns(), of_scale.rows(), of_scale.take()});
}

size_t BlockTops::bytes() const {
  size_t bytes = 0;
  for (const Level& level : levels_) bytes += level.squares.capacity() * sizeof(Square);
  return bytes;
}

}  // namespace foreland::server
