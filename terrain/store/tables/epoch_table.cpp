#include "terrain/store/tables/epoch_table.h"

#include <algorithm>
#include <cstring>

namespace foreland::terrain {

namespace {

// The next `count` values of a section.
template <class T>
std::span<const T> take(ByteSpan& bytes, size_t count) {
  const std::span<const T> values(reinterpret_cast<const T*>(bytes.data()), count);
  bytes = bytes.subspan(count * sizeof(T));
  return values;
}

// The entry of a key; null if there is none.
const BlockEntry* find(std::span<const BlockEntry> entries, uint32_t key) {
  const auto at =
      std::lower_bound(entries.begin(), entries.end(), key, [](const BlockEntry& e, uint32_t k) { return e.key < k; });
  return at != entries.end() && at->key == key ? &*at : nullptr;
}

}  // namespace

Result<EpochTable> EpochTable::read(const proto::GridTopology& grid, ByteSpan bytes, proto::EpochBlend blend) {
  const auto malformed = [](const char* what) { return Error{ErrorCode::kMalformed, what}; };
  EpochTable table;
  if (bytes.empty()) return table;
  EpochSectionStart start;
  if (bytes.size() < sizeof(start)) return malformed("its epochs are cut short");
  std::memcpy(&start, bytes.data(), sizeof(start));
  const uint64_t wanted = sizeof(start) + sizeof(StoredEpoch) * uint64_t{start.epochs} +
                          sizeof(BlockEntry) * uint64_t{start.entries} + sizeof(OffsetBlock) * uint64_t{start.blocks} +
                          sizeof(proto::BaseOffset) * uint64_t{start.base_offsets};
  if (wanted != bytes.size()) return malformed("its epochs are not as large as they say");
  bytes = bytes.subspan(sizeof(start));
  table.stored_ = take<StoredEpoch>(bytes, start.epochs);
  table.entries_ = take<BlockEntry>(bytes, start.entries);
  table.blocks_ = take<OffsetBlock>(bytes, start.blocks);
  const auto base = take<proto::BaseOffset>(bytes, start.base_offsets);
  std::vector<proto::Epoch> epochs;
  for (const StoredEpoch& e : table.stored_) {
    if (uint64_t{e.first_entry} + e.entry_count > start.entries) return malformed("an epoch's offsets are missing");
    epochs.push_back({Time{e.time_us}, {e.x, e.y, e.width, e.height}});
  }
  auto checked = proto::Epochs::create(grid.shape(), std::move(epochs), blend);
  if (!checked) return checked.error();
  table.epochs_ = std::move(*checked);
  const proto::GridShape& s = grid.shape();
  const uint64_t vertices = (s.roots_x + 1ull) * (s.roots_y + 1ull) + static_cast<uint64_t>(s.roots_x) * s.roots_y;
  for (const proto::BaseOffset& b : base)
    if (b.epoch >= start.epochs || b.vertex >= vertices || b.quanta < -proto::kMaxOffset ||
        b.quanta > proto::kMaxOffset)
      return malformed("an offset of a base vertex is damaged");
  table.base_.assign(base.begin(), base.end());
  proto::sortBaseOffsets(table.base_);
  return table;
}

// What a damaged file says is kept within bounds; verify finds the damage.
int32_t EpochTable::offset(uint32_t epoch, proto::Slot slot) const {
  const OffsetBlock* block = blockOf(epoch, static_cast<uint32_t>(slot / 64));
  return block ? clamped((*block)[slot % 64]) : 0;
}

const OffsetBlock* EpochTable::blockOf(uint32_t epoch, uint32_t key) const {
  const BlockEntry* at = find(entriesOf(epoch), key);
  return at && at->block < blocks_.size() ? &blocks_[at->block] : nullptr;
}

int32_t EpochTable::offset(uint32_t epoch, const proto::GridTopology& grid, proto::NodeId v) const {
  if (!grid.isBase(v)) return offset(epoch, grid.slot(v));
  return proto::baseOffsetAt(base_, epoch, proto::baseVertexNumber(grid, v));
}

uint32_t EpochTable::maxOffset() const {
  int64_t most = 0;
  for (const OffsetBlock& block : blocks_)
    for (const int32_t quanta : block) most = std::max(most, std::abs(int64_t{quanta}));
  for (const proto::BaseOffset& b : base_) most = std::max(most, std::abs(int64_t{b.quanta}));
  return static_cast<uint32_t>(std::min(most, int64_t{proto::kMaxOffset}));
}

size_t EpochTable::newBlocks(uint32_t epoch) const {
  if (epoch == 0) return entriesOf(epoch).size();
  const auto before = entriesOf(epoch - 1);
  return static_cast<size_t>(std::ranges::count_if(entriesOf(epoch), [&](const BlockEntry& entry) {
    const BlockEntry* at = find(before, entry.key);
    return !at || at->block != entry.block;
  }));
}

}  // namespace foreland::terrain
