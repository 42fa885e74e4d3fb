// The nodes of one level on one lattice row, evenly spaced. Bounds are computed a row at a time, so that the compiler
// can vectorise over the nodes. A level of sides has two kinds of row: on rows of its squares' corners lie the sides
// along x, on those of their centres the sides along y. Value type; any thread.
#pragma once

#include <algorithm>
#include <cstdint>

#include "proto/topology/grid.h"

namespace foreland::terrain {

inline constexpr uint32_t kTileCells = 16;  // cells a side of a tile of slots: in a run, so many are consecutive

struct NodeRow {
  uint32_t y = 0;
  uint32_t first_x = 0;
  uint32_t step_x = 1;
  uint32_t count = 0;
  uint32_t slot_step = 1;  // between neighbours of a run

  proto::NodeId node(uint32_t i) const { return proto::NodeId::at(first_x + i * step_x, y); }

  // Calls visit(i, slot, count) for each run of up to kTileCells nodes whose slots are slot, slot + slot_step, ...
  template <class Visit>
  void forEachRun(const proto::GridTopology& grid, const Visit& visit) const {
    for (uint32_t i = 0; i < count; i += kTileCells) visit(i, grid.slot(node(i)), std::min(kTileCells, count - i));
  }
};

// The nodes of one level: cells of 2s samples a side, with one centre, or two sides, each.
struct NodeLevel {
  int level = 0;
  bool sides = false;
  uint32_t s = 1;        // half a cell; the reach of a node's support
  uint32_t cells_x = 0;  // whole cells
  uint32_t cells_y = 0;

  NodeLevel(const proto::GridTopology& grid, int number)
      : level(number),
        sides(number & 1),
        s(grid.rootSize() >> (1 + number / 2)),
        cells_x(grid.maxX() / (2 * s)),
        cells_y(grid.maxY() / (2 * s)) {}

  uint32_t cellRows() const { return cells_y + (sides ? 1 : 0); }
  uint32_t bands() const { return (cellRows() + kTileCells - 1) / kTileCells; }

  // Nodes of the lattice row y, a multiple of s at which the level has nodes.
  NodeRow row(uint32_t y) const {
    if (!sides) return {y, s, 2 * s, cells_x, 1};
    if (y % (2 * s) == 0) return {y, s, 2 * s, cells_x, 2};
    return {y, 0, 2 * s, cells_x + 1, 2};
  }
};

}  // namespace foreland::terrain
