// The section of epochs as it lies in a scene file, and how it is made. Change docs/SCENE_FORMAT.md with it.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <span>
#include <type_traits>
#include <utility>
#include <vector>

#include "base/bytes.h"
#include "base/result.h"
#include "proto/section/epochs.h"
#include "terrain/store/file/spool_file.h"

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

// Collects epochs, in order; their offsets wait in a file, so that memory does not grow by them. One owner.
class EpochSection {
 public:
  // For a scene file at `target`.
  static Result<EpochSection> create(const std::filesystem::path& target);

  // The next epoch, whose blocks follow: those that are not all zeros, by ascending keys.
  Status add(const proto::Epoch& epoch);
  Status add(uint32_t key, const OffsetBlock& block);
  void add(const proto::BaseOffset& base) { base_.push_back(base); }
  // Bytes of offsets that the last epoch added and that no epoch before it has.
  uint64_t lastBytes() const;

  // Size of the whole section; 0 without epochs.
  uint64_t bytes() const;
  // Calls put(offset, bytes) for all of its bytes(), in pieces.
  Status write(const std::function<Status(uint64_t offset, ByteSpan what)>& put) const;

 private:
  explicit EpochSection(SpoolFile spool) : spool_(std::move(spool)) {}
  Status flush();
  Result<bool> isAt(uint32_t number, const OffsetBlock& block) const;

  SpoolFile spool_;  // of blocks
  std::vector<OffsetBlock> waiting_;
  std::vector<StoredEpoch> epochs_;
  std::vector<BlockEntry> entries_;
  std::vector<proto::BaseOffset> base_;
  uint32_t blocks_ = 0, blocks_before_ = 0;  // of all epochs, of all but the last one
  size_t before_ = 0;                        // the entry of the epoch before that is next by key
};

}  // namespace foreland::terrain
