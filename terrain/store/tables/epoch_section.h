// The section of epochs as it lies in a scene file, and how it is made. Change docs/SCENE_FORMAT.md with it.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <span>
#include <type_traits>
#include <vector>

#include "base/bytes.h"
#include "proto/section/epochs.h"

namespace foreland::terrain {

// Followed by `epochs` StoredEpoch, `entries` BlockEntry, `blocks` OffsetBlock and `base_offsets` proto::BaseOffset.
struct EpochSectionStart {
  uint32_t epochs = 0, entries = 0, blocks = 0, base_offsets = 0;
};
struct StoredEpoch {
  int64_t time_us;
  uint32_t x, y, width, height;       // where offsets may differ from zero
  uint32_t first_entry, entry_count;  // of its blocks, ascending
};
// Where the offsets of the slots from 64 * key on are; those of no entry are zero. Epochs share blocks that are equal.
struct BlockEntry {
  uint32_t key, block;
};
using OffsetBlock = std::array<int32_t, 64>;  // quanta, by slot
static_assert(sizeof(StoredEpoch) == 32 && sizeof(BlockEntry) == 8 && sizeof(OffsetBlock) == 256);
static_assert(sizeof(proto::BaseOffset) == 12 && std::is_trivially_copyable_v<proto::BaseOffset>);

// The blocks of an epoch that are not all zeros, by key.
using EpochBlocks = std::map<uint32_t, OffsetBlock>;

// Collects epochs, in order. One owner.
class EpochSection {
 public:
  void add(const proto::Epoch& epoch, const EpochBlocks& blocks);
  void add(const proto::BaseOffset& base) { base_.push_back(base); }
  // Bytes of offsets that the last epoch added and that no epoch before it has.
  uint64_t lastBytes() const { return last_bytes_; }
  // Empty without epochs.
  Bytes bytes() const;

 private:
  std::vector<StoredEpoch> epochs_;
  std::vector<BlockEntry> entries_;
  std::vector<OffsetBlock> blocks_;
  std::vector<proto::BaseOffset> base_;
  uint64_t last_bytes_ = 0;
};

}  // namespace foreland::terrain
