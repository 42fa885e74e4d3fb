// Squares of the lattice over which a scene's ground is flat but for one diagonal: no node that is there lies within
// them or on their sides, but at the corners. They tile the data, in an order that depends on the scene alone; where
// pages are not there they are large, so that whoever needs all of the ground pays for the nodes that are there. Pure;
// any thread.
#pragma once

#include <array>
#include <cstdint>

#include "proto/section/page_directory.h"
#include "proto/topology/grid.h"

namespace foreland::terrain {

class FlatSquares {
 public:
  FlatSquares(const proto::GridTopology& grid, const proto::PageDirectory& pages) : grid_(grid), pages_(pages) {}

  // Calls visit(x, y, side) for those that hold data beyond their border: with a south-western corner and a side, a
  // power of two, in samples. None reaches beyond the data.
  template <class Visit>
  void forEach(const Visit& visit) const {
    const proto::GridShape& shape = grid_.shape();
    for (uint32_t y = 0; y < shape.roots_y; ++y)
      for (uint32_t x = 0; x < shape.roots_x; ++x)
        split(x << shape.root_log2, y << shape.root_log2, 1u << shape.root_log2, visit);
  }

  // The same for those that meet a window of the lattice, both corners included.
  template <class Visit>
  void forEachIn(uint32_t low_x, uint32_t low_y, uint32_t high_x, uint32_t high_y, const Visit& visit) const {
    const uint32_t k = grid_.shape().root_log2;
    const auto in_window = [&](uint32_t x, uint32_t y, uint32_t side) {
      return x <= high_x && y <= high_y && x + side >= low_x && y + side >= low_y;
    };
    for (uint32_t y = low_y >> k; y <= high_y >> k && y < grid_.shape().roots_y; ++y)
      for (uint32_t x = low_x >> k; x <= high_x >> k && x < grid_.shape().roots_x; ++x)
        splitIf(x << k, y << k, 1u << k, visit, in_window);
  }

  // Whether a square with a corner at multiples of its side has no node that is there but its corners.
  bool isFlat(uint32_t x, uint32_t y, uint32_t side) const {
    if (side == 1) return true;
    const uint32_t half = side / 2;
    const uint32_t root_x = x >> grid_.shape().root_log2;
    const auto at = [&](uint32_t dx, uint32_t dy) { return grid_.nameIn(root_x, proto::NodeId::at(x + dx, y + dy)); };
    const std::array<proto::NodeId, 5> nodes{at(half, half), at(half, 0), at(0, half), at(half, side), at(side, half)};
    for (const proto::NodeId n : nodes)
      if (const int level = grid_.level(n); level == 0 || pages_.hasPage(grid_.slot(n, level))) return false;
    return true;
  }

 private:
  template <class Visit, class Wanted>
  void splitIf(uint32_t x, uint32_t y, uint32_t side, const Visit& visit, const Wanted& isWanted) const {
    const proto::GridShape& shape = grid_.shape();
    if (x + 1 >= shape.samples_x || y + 1 >= shape.samples_y || !isWanted(x, y, side)) return;
    if (x + side < shape.samples_x && y + side < shape.samples_y && isFlat(x, y, side)) return visit(x, y, side);
    const uint32_t half = side / 2;
    splitIf(x, y, half, visit, isWanted);
    splitIf(x + half, y, half, visit, isWanted);
    splitIf(x, y + half, half, visit, isWanted);
    splitIf(x + half, y + half, half, visit, isWanted);
  }
  template <class Visit>
  void split(uint32_t x, uint32_t y, uint32_t side, const Visit& visit) const {
    splitIf(x, y, side, visit, [](uint32_t, uint32_t, uint32_t) { return true; });
  }

  const proto::GridTopology& grid_;
  const proto::PageDirectory& pages_;
};

}  // namespace foreland::terrain
