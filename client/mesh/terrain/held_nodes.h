// The terrain nodes that a replica holds: those of the two sections drawn at a mesh's beginning and end, with their
// records, and which of the two each belongs to. A step to the next mesh costs O(changes). One owner.
#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <vector>

#include "client/mesh/weights/morphs.h"
#include "proto/section/node_tables.h"
#include "proto/section/section.h"

namespace foreland::client {

class HeldNodes {
 public:
  HeldNodes(const proto::GridTopology& grid, proto::BaseHeights base) : records_(grid, base) {}

  // The records of the two sections' nodes, and of others that are only known of.
  proto::SparseNodes& records() { return records_; }
  const proto::SparseNodes& records() const { return records_; }
  // Which sections a node is in: kInFrom | kInTo.
  uint8_t in(proto::Slot slot) const { return membership(records_.block(slot)).in(slot); }

  // What was `to` becomes `from`, and `to` changes by the delta, whose added nodes must have records.
  void step(const proto::CutDelta& delta);
  // Makes both sections empty; the records stay.
  void clearSections() {
    memberships_.clear();
    changed_.clear();
  }
  // Drops the records of blocks that neither section needs and for which isKnown(first slot of the block) is false.
  // Does nothing until there are twice as many blocks as it left the last time, so its cost is amortised.
  template <class IsKnown>
  void forget(const IsKnown& isKnown);

  proto::Section newest() const;  // `to`

  // Numbers the nodes of both sections 0, 1, ..., block by block and by ascending slot.
  class Index;

 private:
  // Which slots of a block are in either section, a bit each.
  struct Membership {
    uint64_t from = 0, to = 0;
    uint8_t in(proto::Slot slot) const {
      const auto at = static_cast<uint32_t>(slot % proto::SparseNodes::kBlockSlots);
      return static_cast<uint8_t>((from >> at & 1) * kInFrom | (to >> at & 1) * kInTo);
    }
  };
  static_assert(proto::SparseNodes::kBlockSlots == 64);
  static constexpr uint32_t kFewBlocks = 256;

  // Blocks that were made since the last step have no entry yet: none of their nodes is in a section.
  Membership membership(uint32_t block) const {
    return block < memberships_.size() ? memberships_[block] : Membership{};
  }
  uint32_t changedBlock(proto::Slot slot);
  std::vector<uint32_t> blocksInOrder() const;  // those with nodes of either section, by ascending slot

  proto::SparseNodes records_;
  std::vector<Membership> memberships_;  // by block
  std::vector<uint32_t> changed_;        // blocks in which the two sections may differ
  uint32_t max_blocks_ = kFewBlocks;
};

template <class IsKnown>
void HeldNodes::forget(const IsKnown& isKnown) {
  if (records_.blockCount() <= max_blocks_) return;
  memberships_.resize(records_.blockCount());
  uint32_t kept = 1;
  changed_.clear();
  records_.retain([&](uint32_t block) {
    const Membership m = memberships_[block];
    if ((m.from | m.to) == 0 && !isKnown(records_.first(block))) return false;
    if (m.from != m.to) changed_.push_back(kept);
    memberships_[kept++] = m;
    return true;
  });
  memberships_.resize(kept);
  max_blocks_ = 2 * kept + kFewBlocks;
}

// A view of the nodes, valid until they change.
class HeldNodes::Index {
 public:
  static constexpr uint32_t kAbsent = 0xffffffffu;

  struct Found {
    uint32_t position = kAbsent;  // in the numbering
    uint8_t in = 0;               // kInFrom | kInTo
    uint32_t block = proto::SparseNodes::kNone;
    proto::Slot slot = 0;
  };

  // `morphs` are nodes of either section in transition; all others have the weights 0 and 1 of their sections.
  explicit Index(const HeldNodes& nodes, std::span<const Morph> morphs = {});
  uint32_t size() const { return size_; }
  uint32_t fromCount() const { return from_count_; }
  uint32_t toCount() const { return to_count_; }

  // The node, or the default Found if it is in neither section. O(1).
  Found find(proto::Slot slot) const {
    const uint32_t number = nodes_.records_.block(slot);
    const Block& block = blocks_[number];
    const uint64_t all = block.sections.from | block.sections.to;
    const auto at = static_cast<uint32_t>(slot % proto::SparseNodes::kBlockSlots);
    if (!(all >> at & 1)) return {};
    return {block.begin + static_cast<uint32_t>(std::popcount(all & ((uint64_t{1} << at) - 1))),
            block.sections.in(slot), number, slot};
  }
  // The height of a node that was found, in quanta, and its weights at the two ends.
  int32_t height(const Found& node) const { return heights_[node.position]; }
  std::array<double, 2> weight(const Found& node) const {
    const Morph* m = morph(node);
    return m ? std::array{m->from, m->to} : weightsOf(node.in);
  }
  // Null if it is in no transition.
  const Morph* morph(const Found& node) const {
    const bool is_between = blocks_[node.block].in_transition >> (node.slot % proto::SparseNodes::kBlockSlots) & 1;
    return is_between ? findMorph(morphs_, node.slot) : nullptr;
  }

 private:
  // What find() and weight() read of a block, in one record.
  struct Block {
    Membership sections;
    uint64_t in_transition = 0;  // nodes whose weights are not those of their sections, a bit each
    uint32_t begin = 0;          // the position of its first node
  };

  const HeldNodes& nodes_;
  std::span<const Morph> morphs_;
  std::vector<Block> blocks_;     // by number
  std::vector<int32_t> heights_;  // by position: records lie too far apart to be read in the order of a mesh
  uint32_t size_ = 0, from_count_ = 0, to_count_ = 0;
};

}  // namespace foreland::client
