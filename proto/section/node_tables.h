// The records of nodes as either end holds them: the server all of a scene's, the client those that it was sent. Both
// give a vertex's height, base vertices included.
#pragma once

#include <algorithm>
#include <bit>
#include <span>
#include <vector>

#include "proto/section/bounds.h"

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

// Where the height of a vertex stands: in its record, or here for a base vertex. A view.
struct VertexHeight {
  const NodeRecord* record = nullptr;
  int32_t base = 0;

  int32_t height() const { return record ? record->height() : base; }
  int32_t displacement() const { return record ? record->displacement() : 0; }
};

// Every node of a scene, by slot. A view; immutable; any thread.
class DenseNodes {
 public:
  DenseNodes(const GridTopology& grid, BaseHeights base, std::span<const NodeRecord> nodes)
      : grid_(&grid), base_(base), nodes_(nodes.data()) {}

  const NodeRecord& at(Slot slot) const { return nodes_[slot]; }
  VertexHeight find(NodeId v) const {
    return grid_->isBase(v) ? VertexHeight{nullptr, base_.at(*grid_, v)} : VertexHeight{&nodes_[grid_->slot(v)], 0};
  }
  int32_t height(NodeId v) const { return find(v).height(); }

 private:
  const GridTopology* grid_;
  BaseHeights base_;
  const NodeRecord* nodes_;
};

// Some nodes of a scene, in blocks of slots that follow one another: neighbours share a block, and a block is found by
// one probe of a table that holds blocks only. Grows as it fills; forgets whole blocks. One owner.
class SparseNodes {
 public:
  static constexpr Slot kBlockSlots = 64;

  SparseNodes(const GridTopology& grid, BaseHeights base) : grid_(&grid), base_(base), cells_(64) {}

  // A record of zeros, or one that was there before, if the node is not there.
  const NodeRecord& at(Slot slot) const { return records_[place(block(slot), slot)]; }
  VertexHeight find(NodeId v) const {
    return grid_->isBase(v) ? VertexHeight{nullptr, base_.at(*grid_, v)} : VertexHeight{&at(grid_->slot(v)), 0};
  }
  int32_t height(NodeId v) const { return find(v).height(); }
  // The node's record, made if it is not there; valid until the next call.
  NodeRecord& make(Slot slot) {
    uint32_t number = block(slot);
    if (number == kNone) number = makeBlock(slot / kBlockSlots);
    return records_[place(number, slot)];
  }

  // Blocks have numbers from 1 on; kNone if the slot's is not there.
  static constexpr uint32_t kNone = 0;
  uint32_t block(Slot slot) const { return cells_[probe(slot / kBlockSlots)].block; }
  // One past the largest number.
  uint32_t blockCount() const { return static_cast<uint32_t>(keys_.size()); }
  Slot first(uint32_t number) const { return keys_[number] * kBlockSlots; }
  // Of a slot of a block that is there.
  const NodeRecord& at(uint32_t number, Slot slot) const { return records_[place(number, slot)]; }

  // Forgets the blocks but those of which keep(number) is true, which is asked once of each, ascending. These get the
  // numbers from 1 on.
  template <class Keep>
  void retain(const Keep& keep) {
    uint32_t kept = 1;
    for (uint32_t number = 1; number < blockCount(); ++number) {
      if (!keep(number)) continue;
      keys_[kept] = keys_[number];
      std::copy_n(records_.begin() + static_cast<std::ptrdiff_t>(place(number, 0)), kBlockSlots,
                  records_.begin() + static_cast<std::ptrdiff_t>(place(kept++, 0)));
    }
    keys_.resize(kept);
    records_.resize(place(kept, 0));
    keys_.shrink_to_fit();
    records_.shrink_to_fit();
    index(std::bit_ceil(size_t{64} + 2 * kept));
  }

 private:
  struct Cell {
    uint32_t key = 0, block = kNone;
  };
  static size_t place(uint32_t number, Slot slot) { return size_t{number} * kBlockSlots + slot % kBlockSlots; }
  // The cell of a key, or the empty one where it would be.
  size_t probe(uint32_t key) const {
    const size_t mask = cells_.size() - 1;
    const uint32_t h = key * 0x9e3779b1u;
    size_t at = (h ^ (h >> 15)) & mask;
    while (cells_[at].key != key && cells_[at].block != kNone) at = (at + 1) & mask;
    return at;
  }
  uint32_t makeBlock(uint32_t key) {
    const uint32_t number = blockCount();
    keys_.push_back(key);
    records_.resize(place(number + 1, 0));
    if (2 * keys_.size() > cells_.size())
      index(2 * cells_.size());
    else
      cells_[probe(key)] = {key, number};
    return number;
  }
  void index(size_t cells) {
    cells_.assign(cells, {});
    for (uint32_t number = 1; number < blockCount(); ++number) cells_[probe(keys_[number])] = {keys_[number], number};
  }

  const GridTopology* grid_;
  BaseHeights base_;
  std::vector<Cell> cells_;        // a power of two, open addressing; an empty cell's key says nothing
  std::vector<uint32_t> keys_{0};  // slot / kBlockSlots, by number; of kNone nothing
  std::vector<NodeRecord> records_ = std::vector<NodeRecord>(kBlockSlots);  // by number; those of kNone are zeros
};

}  // namespace foreland::proto
