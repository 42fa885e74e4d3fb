// The epochs of a scene file (proto/section/epochs.h): their dates and windows, and the offset of every vertex at every
// epoch. A view of the file's bytes; immutable; any thread. A node's offset takes a binary search.
#pragma once

#include <algorithm>
#include <cstdlib>
#include <set>
#include <span>
#include <vector>

#include "base/bytes.h"
#include "base/result.h"
#include "proto/section/epochs.h"
#include "terrain/store/tables/epoch_section.h"

namespace foreland::terrain {

class EpochTable final : public proto::OffsetSource {
 public:
  // Of a scene that does not change in time.
  EpochTable() = default;
  // The section's bytes, which must outlive it and be aligned to 8; no epochs if there are none. An Error says what is
  // damaged. Costs the same for any number of offsets.
  static Result<EpochTable> read(const proto::GridTopology& grid, ByteSpan bytes,
                                 proto::EpochBlend blend = proto::EpochBlend::kLinear);

  const proto::Epochs& epochs() const { return epochs_; }
  std::span<const proto::BaseOffset> baseOffsets() const { return base_; }
  int32_t offset(uint32_t epoch, proto::Slot slot) const override;
  // Of any vertex.
  int32_t offset(uint32_t epoch, const proto::GridTopology& grid, proto::NodeId v) const;

  // The largest offset either way. O(offsets).
  uint32_t maxOffset() const;
  // Calls visit(i, what is wrong) for every fault in the entries and offsets of epoch i. O(offsets).
  template <class Visit>
  void check(const proto::GridTopology& grid, const Visit& visit) const;
  // Calls visit(vertex, its offset at each epoch) for every node that is in a block of any, and for base vertices that
  // move. O(offsets).
  template <class Visit>
  void forEachMoving(const proto::GridTopology& grid, const Visit& visit) const;
  // How many blocks an epoch has that the one before it has not.
  size_t newBlocks(uint32_t epoch) const;

 private:
  std::span<const BlockEntry> entriesOf(uint32_t epoch) const {
    return entries_.subspan(stored_[epoch].first_entry, stored_[epoch].entry_count);
  }

  // The offsets of 64 slots at an epoch; null if they are zeros, or missing.
  const OffsetBlock* blockOf(uint32_t epoch, uint32_t key) const;
  static int32_t clamped(int32_t quanta) { return std::clamp(quanta, -proto::kMaxOffset, proto::kMaxOffset); }

  proto::Epochs epochs_;
  std::span<const StoredEpoch> stored_;
  std::span<const BlockEntry> entries_;
  std::span<const OffsetBlock> blocks_;
  std::vector<proto::BaseOffset> base_;  // by epoch and vertex
};

template <class Visit>
void EpochTable::check(const proto::GridTopology& grid, const Visit& visit) const {
  for (uint32_t epoch = 0; epoch < epochs_.size(); ++epoch) {
    uint64_t next = 0;
    for (const BlockEntry& entry : entriesOf(epoch)) {
      if (entry.key < next || entry.block >= blocks_.size()) {
        visit(epoch, "its blocks of offsets are not in order");
        break;
      }
      next = uint64_t{entry.key} + 1;
      for (uint32_t low = 0; low < blocks_[entry.block].size(); ++low) {
        const int64_t quanta = blocks_[entry.block][low];
        if (quanta == 0) continue;
        const uint64_t slot = uint64_t{entry.key} * 64 + low;
        const proto::NodeId n = slot < grid.slotCount() ? grid.node(static_cast<proto::Slot>(slot)) : proto::NodeId{};
        if (n == proto::NodeId{} || !epochs_.mayMove(epoch, n)) visit(epoch, "an offset is of no node in its window");
        if (std::abs(quanta) > proto::kMaxOffset) visit(epoch, "an offset is absurd");
      }
    }
  }
}

template <class Visit>
void EpochTable::forEachMoving(const proto::GridTopology& grid, const Visit& visit) const {
  std::set<uint32_t> keys;
  for (const BlockEntry& entry : entries_) keys.insert(entry.key);
  std::vector<int32_t> quanta(epochs_.size());
  for (const uint32_t key : keys) {
    std::vector<const OffsetBlock*> blocks;
    for (uint32_t epoch = 0; epoch < epochs_.size(); ++epoch) blocks.push_back(blockOf(epoch, key));
    for (uint32_t low = 0; low < std::tuple_size_v<OffsetBlock>; ++low) {
      const uint64_t slot = uint64_t{key} * 64 + low;
      const proto::NodeId n = slot < grid.slotCount() ? grid.node(static_cast<proto::Slot>(slot)) : proto::NodeId{};
      if (n == proto::NodeId{}) continue;
      for (size_t epoch = 0; epoch < blocks.size(); ++epoch)
        quanta[epoch] = blocks[epoch] ? clamped((*blocks[epoch])[low]) : 0;
      visit(n, std::span<const int32_t>(quanta));
    }
  }
  std::set<uint32_t> vertices;
  for (const proto::BaseOffset& b : base_) vertices.insert(b.vertex);
  for (const uint32_t vertex : vertices) {
    for (uint32_t epoch = 0; epoch < epochs_.size(); ++epoch) quanta[epoch] = proto::baseOffsetAt(base_, epoch, vertex);
    visit(proto::baseVertex(grid, vertex), std::span<const int32_t>(quanta));
  }
}

}  // namespace foreland::terrain
