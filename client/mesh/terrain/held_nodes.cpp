#include "client/mesh/terrain/held_nodes.h"

#include <algorithm>

#include "base/sort.h"

namespace foreland::client {

uint32_t HeldNodes::changedBlock(proto::Slot slot) {
  const uint32_t block = records_.block(slot);
  if (changed_.empty() || changed_.back() != block) changed_.push_back(block);
  return block;
}

void HeldNodes::step(const proto::CutDelta& delta) {
  memberships_.resize(records_.blockCount());
  for (uint32_t block : changed_) memberships_[block].from = memberships_[block].to;
  changed_.clear();
  const auto bit = [](proto::Slot slot) { return uint64_t{1} << (slot % proto::SparseNodes::kBlockSlots); };
  for (proto::Slot slot : delta.removed) memberships_[changedBlock(slot)].to &= ~bit(slot);
  for (proto::Slot slot : delta.added) memberships_[changedBlock(slot)].to |= bit(slot);
}

std::vector<uint32_t> HeldNodes::blocksInOrder() const {
  std::vector<uint32_t> blocks;
  for (uint32_t block = 1; block < memberships_.size(); ++block)
    if ((memberships_[block].from | memberships_[block].to) != 0) blocks.push_back(block);
  foreland::sort(blocks.begin(), blocks.end(),
                 [this](uint32_t a, uint32_t b) { return records_.first(a) < records_.first(b); });
  return blocks;
}

proto::Section HeldNodes::newest() const {
  proto::Section section;
  for (uint32_t block : blocksInOrder())
    for (uint64_t left = memberships_[block].to; left != 0; left &= left - 1)
      section.slots.push_back(records_.first(block) + static_cast<uint32_t>(std::countr_zero(left)));
  return section;
}

HeldNodes::Index::Index(const HeldNodes& nodes, std::span<const Morph> morphs)
    : nodes_(nodes), morphs_(morphs), blocks_(nodes.records_.blockCount()) {
  for (const Morph& m : morphs)
    if (weightsOf(m.in) != std::array{m.from, m.to})
      blocks_[nodes.records_.block(m.slot)].in_transition |= uint64_t{1} << (m.slot % proto::SparseNodes::kBlockSlots);
  for (uint32_t number : nodes.blocksInOrder()) {
    const Membership m = nodes.memberships_[number];
    blocks_[number].sections = m;
    blocks_[number].begin = size_;
    for (uint64_t left = m.from | m.to; left != 0; left &= left - 1)
      heights_.push_back(nodes.records_.at(number, static_cast<uint32_t>(std::countr_zero(left))).height());
    size_ += static_cast<uint32_t>(std::popcount(m.from | m.to));
    from_count_ += static_cast<uint32_t>(std::popcount(m.from));
    to_count_ += static_cast<uint32_t>(std::popcount(m.to));
  }
}

}  // namespace foreland::client
