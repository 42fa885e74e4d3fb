// The records of nodes as either end holds them: the server all of a scene's, the client those that it was sent. Both
// give a vertex's height, base vertices included.
#pragma once

#include <span>
#include <vector>

#include "proto/bounds.h"

namespace foreland::proto {

// Heights of a grid's base vertices, in steps, row by row from the south. A view.
struct BaseHeights {
  std::span<const int32_t> corners;  // (roots_x + 1) * (roots_y + 1)
  std::span<const int32_t> centres;  // roots_x * roots_y

  int32_t at(const GridTopology& grid, NodeId base) const {
    const uint32_t k = grid.shape().root_log2, x = base.x() >> k, y = base.y() >> k;
    if (grid.scaleLog2(base) >= k) return corners[static_cast<size_t>(y) * (grid.shape().roots_x + 1) + x];
    return centres[static_cast<size_t>(y) * grid.shape().roots_x + x];
  }
};

// Every node of a scene, by slot. A view; immutable; any thread.
class DenseNodes {
 public:
  DenseNodes(const GridTopology& grid, BaseHeights base, std::span<const NodeRecord> nodes)
      : grid_(&grid), base_(base), nodes_(nodes.data()) {}

  const NodeRecord& at(Slot slot) const { return nodes_[slot]; }
  int32_t height(NodeId v) const { return grid_->isBase(v) ? base_.at(*grid_, v) : nodes_[grid_->slot(v)].height(); }

 private:
  const GridTopology* grid_;
  BaseHeights base_;
  const NodeRecord* nodes_;
};

// Some nodes of a scene: open addressing, grows as it fills. One owner.
class SparseNodes {
 public:
  SparseNodes(const GridTopology& grid, BaseHeights base) : grid_(&grid), base_(base), cells_(64) {}

  // A record of zeros if the node is not there.
  const NodeRecord& at(Slot slot) const { return cells_[probe(slot)].record; }
  bool has(Slot slot) const { return cells_[probe(slot)].slot == slot; }
  int32_t height(NodeId v) const { return grid_->isBase(v) ? base_.at(*grid_, v) : at(grid_->slot(v)).height(); }
  size_t size() const { return count_; }

  // The node's record, made if it is not there; valid until the next call.
  NodeRecord& make(Slot slot) {
    size_t cell = probe(slot);
    if (cells_[cell].slot == slot) return cells_[cell].record;
    if (2 * ++count_ > cells_.size()) {
      grow();
      cell = probe(slot);
    }
    cells_[cell].slot = slot;
    return cells_[cell].record;
  }

 private:
  struct Cell {
    Slot slot = kNoSlot;
    NodeRecord record;
  };
  size_t probe(Slot slot) const {
    const size_t mask = cells_.size() - 1;
    const uint32_t h = slot * 0x9e3779b1u;
    size_t at = (h ^ (h >> 15)) & mask;
    while (cells_[at].slot != slot && cells_[at].slot != kNoSlot) at = (at + 1) & mask;
    return at;
  }
  void grow() {
    std::vector<Cell> old(2 * cells_.size());
    old.swap(cells_);
    for (const Cell& cell : old)
      if (cell.slot != kNoSlot) cells_[probe(cell.slot)] = cell;
  }

  const GridTopology* grid_;
  BaseHeights base_;
  std::vector<Cell> cells_;  // a power of two
  size_t count_ = 0;
};

}  // namespace foreland::proto
