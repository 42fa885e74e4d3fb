// What bounds.h computes, block by block: a lattice is cut into squares, of each of which a BlockBounds follows from
// the heights in it and a halo around it alone. Errors and radii are maxima, and maxima go upwards only, so all blocks
// together say what the whole lattice would, to the bit, in any order.
//
// Fine nodes, whose descendants lie within the halo, get their saturated errors; coarse ones the largest error over the
// block's own samples, if the corners of their supports are the block's: half a side apart at most. What is coarser
// still takes one look at the samples of each block, when the heights of all blocks' corners are known.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "base/result.h"
#include "proto/space/geographic_tables.h"
#include "terrain/bounds/bounds.h"
#include "terrain/bounds/error.h"
#include "terrain/bounds/page_reach.h"

namespace foreland::terrain {

// How a lattice is cut. A block has the samples of its square and of all of its border, so neighbours share those; the
// pages of fine nodes are those of one block each.
struct Blocks {
  static constexpr uint32_t kHalo = 32;      // samples around a block that its bounds need
  static constexpr uint32_t kFineLog2 = 4;   // nodes 2^4 and more apart are coarse, but for sides that are 2^4 apart
  static constexpr int kFineLevels = 9;      // the finest of the grid
  static constexpr uint32_t kLeastLog2 = 9;  // a page of the coarsest fine level is as wide as a block
  static constexpr uint32_t kLeastRootLog2 = 6;

  const proto::GridTopology& grid;
  uint32_t log2 = 10;  // of a side, in samples

  // Whether the lattice is large enough to be cut.
  static bool canCut(const proto::GridTopology& grid) {
    return !grid.isCube() && grid.shape().sparse_levels == 0 && grid.shape().root_log2 >= kLeastRootLog2;
  }
  uint32_t columns() const { return ((grid.maxX() - 1) >> log2) + 1; }
  uint32_t rows() const { return ((grid.maxY() - 1) >> log2) + 1; }
  uint64_t count() const { return uint64_t{columns()} * rows(); }
  int coarsestFineLevel() const { return grid.maxLevel() - kFineLevels + 1; }

  // The lattice points of a block, without its halo and with it; both corners included.
  ErrorWindow own(uint32_t column, uint32_t row) const;
  ErrorWindow withHalo(uint32_t column, uint32_t row) const;
  // A block's pages of a fine level.
  PageWindow pages(int level, uint32_t column, uint32_t row) const;
};

inline uint32_t widthOf(const ErrorWindow& w) { return w.high_x - w.low_x + 1; }
inline uint32_t heightOf(const ErrorWindow& w) { return w.high_y - w.low_y + 1; }

struct BlockBounds {
  std::vector<proto::QuantisedError> errors;  // of own(), row by row; 0 for what is no node
  std::vector<std::vector<PageReach>> reach;  // of each fine level, the coarsest first, of its pages
};

// Heights of all points of withHalo(), row by row; beyond the data those of the nearest sample.
using HaloHeights = std::span<const int32_t>;

// Makes the bounds of one block. One owner.
class BlockBounder {
 public:
  // All must outlive it.
  BlockBounder(const Blocks& blocks, const proto::Frame& frame, const proto::GeographicTables& tables, uint32_t column,
               uint32_t row);

  // In a scene that changes in time: the ground at another time, which differs from those before in the lattice rows
  // from first_row to last_row alone. Errors are the largest of all grounds'.
  void addErrors(HaloHeights ground, uint32_t first_row, uint32_t last_row);
  // `ground` is the first one; `extremes` are empty, or in scenes that change in time the lowest and the highest
  // heights at any time. To be called once.
  BlockBounds finish(HaloHeights ground, std::span<const HaloHeights> extremes);

 private:
  proto::QuantisedError& errorAt(uint32_t x, uint32_t y) {
    return result_.errors[size_t{y - own_.low_y} * widthOf(own_) + (x - own_.low_x)];
  }
  // The bounds that the window has as a lattice of its own, by slot; of rows, too.
  std::vector<NodeRecord> boundWindow(HaloHeights ground, uint32_t first_row, uint32_t last_row) const;
  void addFineErrors(HaloHeights ground);
  void addCoarseErrors(HaloHeights ground);
  template <class Error>
  void addCoarseErrors(const Error& error);

  const Blocks& blocks_;
  const proto::GridTopology& grid_;
  const proto::Frame& frame_;
  const proto::GeographicTables& tables_;
  uint32_t column_, row_;
  ErrorWindow own_, halo_;
  std::optional<proto::GridTopology> local_;       // none if no support of the block holds data
  std::vector<proto::QuantisedError> min_errors_;  // by slot of it, at the other times; empty if there are none
  BlockBounds result_;
};

// Calls visit(node) for the nodes that are coarser than a block's own can be and whose supports may reach into it.
template <class Visit>
void forEachAncestor(const Blocks& blocks, uint32_t column, uint32_t row, const Visit& visit) {
  const ErrorWindow own = blocks.own(column, row);
  const uint32_t k = blocks.grid.shape().root_log2;
  for (uint32_t t = blocks.log2; t < k; ++t) {
    const uint32_t s = 1u << t;
    const auto low = [&](uint32_t at) { return at < s ? 0 : (at - s) >> t << t; };
    for (uint32_t y = low(own.low_y); y <= std::min(blocks.grid.maxY(), own.high_y + s); y += s)
      for (uint32_t x = low(own.low_x); x <= std::min(blocks.grid.maxX(), own.high_x + s); x += s)
        if (const proto::NodeId n = proto::NodeId::at(x, y); blocks.grid.scaleLog2(n) == t && !blocks.grid.isBase(n))
          visit(n);
  }
}

}  // namespace foreland::terrain
