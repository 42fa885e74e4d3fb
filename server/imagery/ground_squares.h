// What bounds the ground at full resolution, square by square of the lattice: heights, and how it rises. A pyramid: a
// square holds four of the next finer level. Immutable; any thread. Memory: 40 bytes a square, a third more than those
// of the finest level, which has a square for 4 x 4 samples or, in large scenes, for more. O(samples) to make.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "server/section/hierarchy.h"

namespace foreland::server {

class GroundSquares {
 public:
  explicit GroundSquares(const Hierarchy& hierarchy, size_t max_squares = 1u << 20);

  struct Square {
    float lowest_m, highest_m;
    // Metres a sample at least and at most: along x, along y, along x and y, along x and against y.
    std::array<float, 4> min_rise_m, largest_rise_m;
  };
  uint32_t levels() const { return static_cast<uint32_t>(levels_.size()); }
  // In samples. Square (i, j) is from (i, j) times that to (i + 1, j + 1) times that.
  uint32_t side(uint32_t level) const { return 1u << (finest_log2_ + level); }
  uint32_t columns(uint32_t level) const { return levels_[level].columns; }
  uint32_t rows(uint32_t level) const { return levels_[level].rows; }
  const Square& square(uint32_t level, uint32_t i, uint32_t j) const {
    return levels_[level].squares[size_t{j} * levels_[level].columns + i];
  }
  size_t bytes() const;

 private:
  struct Level {
    uint32_t columns, rows;
    std::vector<Square> squares;
  };
  Level finest(const Hierarchy& hierarchy) const;
  Level finestOfSparse(const terrain::Scene& scene) const;
  static Level coarser(const Level& fine);

  uint32_t finest_log2_ = 2;
  std::vector<Level> levels_;
};

}  // namespace foreland::server
