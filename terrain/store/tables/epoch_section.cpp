#include "terrain/store/tables/epoch_section.h"

#include <algorithm>
#include <utility>

#include "base/check.h"

namespace foreland::terrain {

namespace {

constexpr size_t kBlocksAtOnce = 1024;

template <class T>
ByteSpan bytesOfEpochs(std::span<T> values) {
  return {reinterpret_cast<const uint8_t*>(values.data()), values.size_bytes()};
}

std::span<uint8_t> writableBytesOfBlocks(std::span<OffsetBlock> blocks) {
  return {reinterpret_cast<uint8_t*>(blocks.data()), blocks.size_bytes()};
}

}  // namespace

Result<EpochSection> EpochSection::create(const std::filesystem::path& target) {
  auto spool = SpoolFile::create(target);
  if (!spool) return spool.error();
  return EpochSection(std::move(spool).value());
}

Status EpochSection::flush() {
  if (waiting_.empty()) return {};
  const auto at = spool_.append(bytesOfEpochs(std::span(waiting_)));
  waiting_.clear();
  return at ? Status() : Status(at.error());
}

Status EpochSection::add(const proto::Epoch& epoch) {
  if (Status s = flush(); !s.ok()) return s;
  before_ = epochs_.empty() ? 0 : epochs_.back().first_entry;
  blocks_before_ = blocks_;
  const proto::LatticeWindow& w = epoch.moved;
  epochs_.push_back({epoch.time.us, w.x, w.y, w.width, w.height, static_cast<uint32_t>(entries_.size()), 0});
  return {};
}

Result<bool> EpochSection::isAt(uint32_t number, const OffsetBlock& block) const {
  OffsetBlock stored;
  if (Status s = spool_.read(number * sizeof(OffsetBlock), writableBytesOfBlocks({&stored, 1})); !s.ok())
    return s.error();
  return stored == block;
}

// A block that has not changed since the epoch before is stored once.
Status EpochSection::add(uint32_t key, const OffsetBlock& block) {
  StoredEpoch& epoch = epochs_.back();
  DCHECK_TRUE(epoch.entry_count == 0 || entries_.back().key < key);
  while (before_ < epoch.first_entry && entries_[before_].key < key) ++before_;
  ++epoch.entry_count;
  if (before_ < epoch.first_entry && entries_[before_].key == key) {
    const uint32_t number = entries_[before_].block;
    const auto is_same = isAt(number, block);
    if (!is_same) return is_same.error();
    if (*is_same) {
      entries_.push_back({key, number});
      return {};
    }
  }
  entries_.push_back({key, blocks_++});
  waiting_.push_back(block);
  return waiting_.size() < kBlocksAtOnce ? Status() : flush();
}

uint64_t EpochSection::lastBytes() const {
  return (blocks_ - blocks_before_) * sizeof(OffsetBlock) + epochs_.back().entry_count * sizeof(BlockEntry);
}

uint64_t EpochSection::bytes() const {
  if (epochs_.empty()) return 0;
  return sizeof(EpochSectionStart) + epochs_.size() * sizeof(StoredEpoch) + entries_.size() * sizeof(BlockEntry) +
         blocks_ * sizeof(OffsetBlock) + base_.size() * sizeof(proto::BaseOffset);
}

Status EpochSection::write(const std::function<Status(uint64_t offset, ByteSpan what)>& put) const {
  if (epochs_.empty()) return {};
  const EpochSectionStart start{static_cast<uint32_t>(epochs_.size()), static_cast<uint32_t>(entries_.size()), blocks_,
                                static_cast<uint32_t>(base_.size())};
  uint64_t at = 0;
  const auto putNext = [&](ByteSpan what) -> Status {
    if (what.empty()) return {};
    const Status s = put(at, what);
    at += what.size();
    return s;
  };
  for (const ByteSpan part :
       {bytesOfEpochs(std::span(&start, 1)), bytesOfEpochs(std::span(epochs_)), bytesOfEpochs(std::span(entries_))})
    if (Status s = putNext(part); !s.ok()) return s;
  std::vector<OffsetBlock> some;
  const uint64_t spooled = blocks_ - waiting_.size();
  for (uint64_t done = 0; done < spooled; done += some.size()) {
    some.resize(std::min<uint64_t>(kBlocksAtOnce, spooled - done));
    if (Status s = spool_.read(done * sizeof(OffsetBlock), writableBytesOfBlocks(some)); !s.ok()) return s;
    if (Status s = putNext(bytesOfEpochs(std::span(some))); !s.ok()) return s;
  }
  for (const ByteSpan part : {bytesOfEpochs(std::span(waiting_)), bytesOfEpochs(std::span(base_))})
    if (Status s = putNext(part); !s.ok()) return s;
  return {};
}

}  // namespace foreland::terrain
