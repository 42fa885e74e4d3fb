// How high the terrain stands at most, at any scene time, square by square of the lattice and scale by scale: what a
// line of sight must pass under for nothing of the square to be seen.
//
// At scale t, with s = 2^t, squares have a side of 2 s, and a square's top is the largest height in it, its border
// included. That bounds the true surface, and what is drawn where a node of scale s is the first that is left out: the
// triangle drawn there is half of the node's support, and lies in one such square with its corners at their true
// heights, or between two of these.
//
// Scales whose squares would be more than `max_squares` are not there. Immutable after creation; any thread. Memory:
// four bytes a square, a third more than those of the finest scale.
#pragma once

#include <cstdint>
#include <vector>

#include "server/section/hierarchy.h"

namespace foreland::server {

class BlockTops {
 public:
  BlockTops() = default;  // of nothing
  explicit BlockTops(const Hierarchy& hierarchy, size_t max_squares = 16u << 20);

  uint32_t finestScale() const { return finest_; }
  uint32_t columns(uint32_t scale) const { return levels_[scale - finest_].columns; }
  uint32_t rows(uint32_t scale) const { return levels_[scale - finest_].rows; }
  // Quanta of height: the largest and the least, and a plane above all heights, in its middle and from there to the
  // sides of larger x and y.
  struct Square {
    int32_t top, bottom;
    float height, tilt_x, tilt_y;
  };
  // Its corners are (2 s i, 2 s j) and (2 s (i + 1), 2 s (j + 1)).
  const Square& square(uint32_t scale, uint32_t i, uint32_t j) const {
    const Level& level = levels_[scale - finest_];
    return level.squares[size_t{j} * level.columns + i];
  }
  bool has(uint32_t scale, uint32_t i, uint32_t j) const {
    return scale >= finest_ && scale - finest_ < levels_.size() && i < columns(scale) && j < rows(scale);
  }
  size_t bytes() const;

 private:
  struct Level {
    uint32_t columns, rows;
    std::vector<Square> squares;
  };
  static constexpr size_t kMostOfSparse = 2u << 20;  // squares, where ground is fine in places only
  void addSparse(const terrain::Scene& scene, size_t max_squares);

  uint32_t finest_ = 0;
  std::vector<Level> levels_;
};

}  // namespace foreland::server
