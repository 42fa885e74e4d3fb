#include "terrain/store/tables/epoch_section.h"

#include <cstring>

namespace foreland::terrain {

namespace {

// Copies the values to `at` and moves it behind them.
template <class T>
void putEpochs(std::span<T> values, uint8_t*& at) {
  if (!values.empty()) std::memcpy(at, values.data(), values.size_bytes());
  at += values.size_bytes();
}

}  // namespace

// A block that has not changed since the epoch before is stored once.
void EpochSection::add(const proto::Epoch& epoch, const EpochBlocks& blocks) {
  const std::span<const BlockEntry> before =
      epochs_.empty() ? std::span<const BlockEntry>()
                      : std::span<const BlockEntry>(entries_).subspan(epochs_.back().first_entry);
  std::map<uint32_t, uint32_t> numbers;
  for (const BlockEntry& entry : before) numbers.emplace(entry.key, entry.block);
  const auto first = static_cast<uint32_t>(entries_.size()), old = static_cast<uint32_t>(blocks_.size());
  for (const auto& [key, block] : blocks) {
    const auto same = numbers.find(key);
    const bool is_same = same != numbers.end() && blocks_[same->second] == block;
    entries_.push_back({key, is_same ? same->second : static_cast<uint32_t>(blocks_.size())});
    if (!is_same) blocks_.push_back(block);
  }
  const proto::LatticeWindow& w = epoch.moved;
  epochs_.push_back(
      {epoch.time.us, w.x, w.y, w.width, w.height, first, static_cast<uint32_t>(entries_.size()) - first});
  last_bytes_ = (blocks_.size() - old) * sizeof(OffsetBlock) + (entries_.size() - first) * sizeof(BlockEntry);
}

Bytes EpochSection::bytes() const {
  if (epochs_.empty()) return {};
  const EpochSectionStart start{static_cast<uint32_t>(epochs_.size()), static_cast<uint32_t>(entries_.size()),
                                static_cast<uint32_t>(blocks_.size()), static_cast<uint32_t>(base_.size())};
  Bytes out(sizeof(start) + epochs_.size() * sizeof(StoredEpoch) + entries_.size() * sizeof(BlockEntry) +
            blocks_.size() * sizeof(OffsetBlock) + base_.size() * sizeof(proto::BaseOffset));
  uint8_t* at = out.data();
  putEpochs(std::span(&start, 1), at);
  putEpochs(std::span(epochs_), at);
  putEpochs(std::span(entries_), at);
  putEpochs(std::span(blocks_), at);
  putEpochs(std::span(base_), at);
  return out;
}

}  // namespace foreland::terrain
