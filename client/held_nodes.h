// The nodes of two sections, those drawn at the beginning and the end of a mesh: their records, and which of the two
// each belongs to. Steps from mesh to mesh at a cost that follows the changes. One owner.
#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <vector>

#include "client/morphs.h"
#include "proto/section/node_tables.h"
#include "proto/section/section.h"

namespace foreland::client {

class HeldNodes {
 public:
  HeldNodes(const proto::GridTopology& grid, proto::BaseHeights base) : records_(grid, base) {}

  // The two sections' nodes have their true records; others may be there.
  proto::SparseNodes& records() { return records_; }
  const proto::SparseNodes& records() const { return records_; }
  // kInFrom | kInTo.
  uint8_t in(proto::Slot slot) const { return sets(records_.block(slot)).in(slot); }

  // What was `to` becomes `from`, and `to` changes by the delta, whose added nodes have records.
  void step(const proto::CutDelta& delta);
  // Drops the records of blocks without nodes of the two sections, but for those with isKnown(first slot of the block),
  // once there are twice as many blocks as there were when that was done last.
  template <class IsKnown>
  void forget(const IsKnown& isKnown);

  proto::Section newest() const;  // `to`

  // The nodes of both sections in a row: block by block, by ascending slot.
  class Row;

 private:
  struct Sets {
    uint64_t from = 0, to = 0;  // a bit for each slot of a block
    uint8_t in(proto::Slot slot) const {
      const uint32_t at = slot % proto::SparseNodes::kBlockSlots;
      return static_cast<uint8_t>((from >> at & 1) * kInFrom | (to >> at & 1) * kInTo);
    }
  };
  static_assert(proto::SparseNodes::kBlockSlots == 64);
  static constexpr uint32_t kFew = 256;

  // Blocks that were made since the last step have none yet.
  Sets sets(uint32_t block) const { return block < sets_.size() ? sets_[block] : Sets{}; }
  uint32_t changedBlock(proto::Slot slot);
  std::vector<uint32_t> blocksInOrder() const;  // with nodes of either section, by ascending slots

  proto::SparseNodes records_;
  std::vector<Sets> sets_;         // by block
  std::vector<uint32_t> changed_;  // blocks in which the two sections may differ
  uint32_t most_blocks_ = kFew;
};

template <class IsKnown>
void HeldNodes::forget(const IsKnown& isKnown) {
  if (records_.blockCount() <= most_blocks_) return;
  sets_.resize(records_.blockCount());
  uint32_t kept = 1;
  changed_.clear();
  records_.retain([&](uint32_t block) {
    const Sets sets = sets_[block];
    if ((sets.from | sets.to) == 0 && !isKnown(records_.first(block))) return false;
    if (sets.from != sets.to) changed_.push_back(kept);
    sets_[kept++] = sets;
    return true;
  });
  sets_.resize(kept);
  most_blocks_ = 2 * kept + kFew;
}

// Positions in a row of the nodes of both sections, and their weights. A view: ends when the nodes change.
class HeldNodes::Row {
 public:
  static constexpr uint32_t kAbsent = 0xffffffffu;

  struct Found {
    uint32_t position = kAbsent;
    uint8_t in = 0;
    uint32_t block = proto::SparseNodes::kNone;
    proto::Slot slot = 0;
  };

  // `morphs` have nodes of either section; the weight of others is 1 where they are.
  explicit Row(const HeldNodes& nodes, std::span<const Morph> morphs = {});
  uint32_t size() const { return size_; }
  uint32_t fromCount() const { return from_count_; }
  uint32_t toCount() const { return to_count_; }

  Found find(proto::Slot slot) const {
    const uint32_t number = nodes_.records_.block(slot);
    const Block& block = blocks_[number];
    const uint64_t all = block.sets.from | block.sets.to;
    const uint32_t at = slot % proto::SparseNodes::kBlockSlots;
    if (!(all >> at & 1)) return {};
    return {block.begin + static_cast<uint32_t>(std::popcount(all & ((uint64_t{1} << at) - 1))), block.sets.in(slot),
            number, slot};
  }
  // Of a node that was found: its height (steps), its weights at the two ends.
  int32_t height(const Found& node) const { return heights_[node.position]; }
  std::array<double, 2> weight(const Found& node) const {
    const bool is_between = blocks_[node.block].between >> (node.slot % proto::SparseNodes::kBlockSlots) & 1;
    return is_between ? weightBetween(node.slot) : weightsOf(node.in);
  }

 private:
  // What is looked up together.
  struct Block {
    Sets sets;
    uint64_t between = 0;  // nodes with a weight other than 0 outside a section or 1 in it
    uint32_t begin = 0;    // the position of its first node
  };
  std::array<double, 2> weightBetween(proto::Slot slot) const;

  const HeldNodes& nodes_;
  std::span<const Morph> morphs_;
  std::vector<Block> blocks_;     // by number
  std::vector<int32_t> heights_;  // by position: records lie too far apart to be walked in another order
  uint32_t size_ = 0, from_count_ = 0, to_count_ = 0;
};

}  // namespace foreland::client
