// The records of nodes as either end holds them: the server has all of a scene's, the client those that it was sent.
// Both tables give a vertex's height, base vertices included.
#pragma once

#include <algorithm>
#include <concepts>
#include <span>
#include <vector>

#include "proto/section/bounds.h"
#include "proto/section/index_table.h"
#include "proto/section/page_directory.h"

namespace foreland::proto {

// Heights of a grid's base vertices, in height quanta, row by row from the south. A view.
struct BaseHeights {
  std::span<const int32_t> corners;  // (roots_x + 1) * (roots_y + 1)
  std::span<const int32_t> centres;  // roots_x * roots_y

  int32_t at(const GridTopology& grid, NodeId base) const {
    const uint32_t k = grid.shape().root_log2, x = base.x() >> k, y = base.y() >> k;
    if (grid.scaleLog2(base) >= k) return corners[static_cast<size_t>(y) * (grid.shape().roots_x + 1) + x];
    return centres[static_cast<size_t>(y) * grid.shape().roots_x + x];
  }
};

// Where the height of a vertex is found: in its record, or here for a base vertex. A view.
struct VertexHeight {
  const NodeRecord* record = nullptr;
  int32_t base = 0;

  int32_t height() const { return record ? record->height() : base; }
  int32_t displacement() const { return record ? record->displacement() : 0; }
};

// The records of a scene's nodes, by slot, whatever pages are there. A node whose page is not there reads as zeros: its
// error is 0, so it passes no test. A view; immutable; any thread.
class StoredNodes {
 public:
  StoredNodes() = default;
  // All pages are there.
  template <class Records>
  requires std::convertible_to<const Records&, std::span<const NodeRecord>> StoredNodes(const Records& records)
      : records_(std::span<const NodeRecord>(records).data()), whole_(std::span<const NodeRecord>(records).size()) {}
  // Those of a directory are, which must outlive it.
  StoredNodes(std::span<const NodeRecord> records, const PageDirectory& directory)
      : records_(records.data()), whole_(directory.wholeSlots()), directory_(&directory) {
    CHECK_EQ(records.size(), directory.pageCount() * kPageSlots);
  }

  const NodeRecord& operator[](Slot slot) const { return slot < whole_ ? records_[slot] : inDirectory(slot); }
  bool hasPage(Slot slot) const { return slot < whole_ || (directory_ && directory_->hasPage(slot)); }

 private:
  const NodeRecord& inDirectory(Slot slot) const {
    static constexpr NodeRecord kNone{};
    const uint64_t place = directory_ ? directory_->placeOf(slot) : PageDirectory::kNowhere;
    return place == PageDirectory::kNowhere ? kNone : records_[place];
  }

  const NodeRecord* records_ = nullptr;
  Slot whole_ = 0;  // below it the place of a record is its slot
  const PageDirectory* directory_ = nullptr;
};

// Every node of a scene, by slot. A view; immutable; any thread.
class DenseNodes {
 public:
  DenseNodes(const GridTopology& grid, BaseHeights base, StoredNodes nodes)
      : grid_(&grid), base_(base), nodes_(nodes) {}

  const NodeRecord& at(Slot slot) const { return nodes_[slot]; }
  bool hasPage(Slot slot) const { return nodes_.hasPage(slot); }
  VertexHeight find(NodeId v) const {
    const int level = grid_->level(v);
    return level == 0 ? VertexHeight{nullptr, base_.at(*grid_, v)} : VertexHeight{&at(grid_->slot(v, level)), 0};
  }
  int32_t height(NodeId v) const { return find(v).height(); }

 private:
  const GridTopology* grid_;
  BaseHeights base_;
  StoredNodes nodes_;
};

// Some nodes of a scene, in blocks of slots that follow one another, so neighbours share a block and the table that
// finds blocks stays small. Grows as it fills; forgets whole blocks. One owner.
class SparseNodes {
 public:
  static constexpr Slot kBlockSlots = 64;

  SparseNodes(const GridTopology& grid, BaseHeights base) : grid_(&grid), base_(base) {}

  // The node's record; if the node is not there, a record of zeros or of what was there before.
  const NodeRecord& at(Slot slot) const { return records_[indexOf(block(slot), slot)]; }
  VertexHeight find(NodeId v) const {
    const int level = grid_->level(v);
    return level == 0 ? VertexHeight{nullptr, base_.at(*grid_, v)} : VertexHeight{&at(grid_->slot(v, level)), 0};
  }
  int32_t height(NodeId v) const { return find(v).height(); }
  // The node's record, made if it is not there; valid until the next call.
  NodeRecord& make(Slot slot) {
    uint32_t number = block(slot);
    if (number == kNone) number = makeBlock(slot / kBlockSlots);
    return records_[indexOf(number, slot)];
  }

  // Blocks have numbers from 1 on; kNone if the slot's is not there.
  static constexpr uint32_t kNone = IndexTable::kNone;
  uint32_t block(Slot slot) const { return numbers_.find(slot / kBlockSlots); }
  // One past the largest number.
  uint32_t blockCount() const { return static_cast<uint32_t>(keys_.size()); }
  Slot first(uint32_t number) const { return keys_[number] * kBlockSlots; }
  // The record of a slot whose block has this number.
  const NodeRecord& at(uint32_t number, Slot slot) const { return records_[indexOf(number, slot)]; }

  // Forgets the blocks for which keep(number) is false; it is called once for each, ascending. The blocks kept are
  // numbered anew from 1 on.
  template <class Keep>
  void retain(const Keep& keep) {
    uint32_t kept = 1;
    for (uint32_t number = 1; number < blockCount(); ++number) {
      if (!keep(number)) continue;
      keys_[kept] = keys_[number];
      std::copy_n(records_.begin() + static_cast<std::ptrdiff_t>(indexOf(number, 0)), kBlockSlots,
                  records_.begin() + static_cast<std::ptrdiff_t>(indexOf(kept++, 0)));
    }
    keys_.resize(kept);
    records_.resize(indexOf(kept, 0));
    keys_.shrink_to_fit();
    records_.shrink_to_fit();
    numbers_.reset(kept);
    for (uint32_t number = 1; number < kept; ++number) numbers_.insert(keys_[number], number);
  }

 private:
  static size_t indexOf(uint32_t number, Slot slot) {
    return size_t{number} * kBlockSlots + static_cast<size_t>(slot % kBlockSlots);
  }
  uint32_t makeBlock(uint64_t key) {
    const uint32_t number = blockCount();
    keys_.push_back(key);
    records_.resize(indexOf(number + 1, 0));
    numbers_.insert(key, number);
    return number;
  }

  const GridTopology* grid_;
  BaseHeights base_;
  IndexTable numbers_;             // of blocks, by slot / kBlockSlots
  std::vector<uint64_t> keys_{0};  // slot / kBlockSlots, by number; that of kNone means nothing
  std::vector<NodeRecord> records_ = std::vector<NodeRecord>(kBlockSlots);  // by number; those of kNone are zeros
};

}  // namespace foreland::proto
