#include "proto/refine/memory/node_memory.h"

#include <algorithm>

#include "base/check.h"

namespace foreland::proto {

namespace {

constexpr size_t kFewBytes = 1024, kFewCells = 16;

// Room for `more` elements beside those of `v`, and for a sixteenth: a session's memory is counted.
void reserveMore(Bytes& v, size_t more) {
  if (v.size() + more > v.capacity()) v.reserve(v.size() + more + kFewBytes / 2 + v.size() / 16);
}

}  // namespace

void NodeMemory::keep(Slot first, const PageKnowledge& knowledge) {
  if (budget_ == 0) return;
  const uint64_t key = first / kPageSlots;
  if (4 * (count_ + 1) > 3 * cells_.size()) makeCells(kFewCells + cells_.size() + cells_.size() / 4);
  const size_t cell = cellOf(key);
  CHECK_EQ(cells_[cell], kNowhere);

  const size_t begin = log_.size();
  static_assert(kMaxPackedBytes < kLong && kSlotBits <= 8 * 6 + 8);
  const size_t key_bytes = keyBytes(key), packed = begin + 1 + key_bytes;
  reserveMore(log_, 1 + key_bytes + kMaxPackedBytes);
  log_.push_back(0);
  for (size_t i = 0; i < key_bytes; ++i) log_.push_back(static_cast<uint8_t>(key >> 8 * i));
  packPage(knowledge, log_);
  log_[begin] = static_cast<uint8_t>(log_.size() - packed) | (key_bytes > 3 ? kLong : 0);
  cells_[cell] = static_cast<Place>(begin);
  ++count_;
  client_bytes_ += knowledge.clientBytes();
  known_ += knowledge.known.count();
  evict();
}

std::optional<PageKnowledge> NodeMemory::take(Slot slot) {
  if (count_ == 0) return std::nullopt;
  const size_t cell = cellOf(slot / kPageSlots);
  if (cells_[cell] == kNowhere) return std::nullopt;
  const Entry entry = entryAt(cells_[cell]);
  const PageKnowledge knowledge = unpackPage(entry.packed);
  remove(cell, entry, knowledge);
  moveUp();
  return knowledge;
}

std::optional<PageKnowledge> NodeMemory::find(Slot slot) const {
  const std::optional<Entry> entry = entryOf(slot);
  return entry ? std::optional(unpackPage(entry->packed)) : std::nullopt;
}

std::optional<QuantisedRadius> NodeMemory::radius(Slot slot) const {
  const std::optional<Entry> entry = entryOf(slot);
  return entry ? std::optional(packedRadius(entry->packed)) : std::nullopt;
}

bool NodeMemory::knowsAnyOf64(Slot first) const {
  const std::optional<Entry> entry = entryOf(first);
  return entry && packedKnowsAnyOf64(entry->packed, first);
}

std::vector<KnownPage> NodeMemory::pages() const {
  std::vector<KnownPage> pages;
  pages.reserve(count_);
  for (Place place = oldest_; place < log_.size();) {
    const Entry entry = entryAt(place);
    if (isUsed(entry.key, place)) pages.push_back({entry.key * kPageSlots, unpackPage(entry.packed)});
    place += static_cast<Place>(entry.size());
  }
  std::reverse(pages.begin(), pages.end());
  return pages;
}

void NodeMemory::clear() {
  const uint64_t budget = budget_;
  *this = {};
  budget_ = budget;
}

NodeMemory::Entry NodeMemory::entryAt(Place place) const {
  const uint8_t* head = &log_[place];
  uint64_t key = static_cast<uint64_t>(head[1] | head[2] << 8 | head[3] << 16);
  if ((head[0] & kLong) == 0) return {key, {head + 4, head[0]}};
  key |= static_cast<uint64_t>(head[4] | head[5] << 8 | head[6] << 16) << 24;
  return {key, {head + 7, static_cast<size_t>(head[0] & ~kLong)}};
}

std::optional<NodeMemory::Entry> NodeMemory::entryOf(Slot slot) const {
  if (count_ == 0) return std::nullopt;
  const Place place = cells_[cellOf(slot / kPageSlots)];
  return place == kNowhere ? std::nullopt : std::optional(entryAt(place));
}

bool NodeMemory::isUsed(uint64_t key, Place place) const { return count_ > 0 && cells_[cellOf(key)] == place; }

void NodeMemory::remove(size_t cell, const Entry& entry, const PageKnowledge& knowledge) {
  unused_ += entry.size();
  freeCell(cell);
  --count_;
  client_bytes_ -= knowledge.clientBytes();
  known_ -= knowledge.known.count();
}

void NodeMemory::evict() {
  while (client_bytes_ > budget_) {
    const Entry entry = entryAt(oldest_);
    if (isUsed(entry.key, oldest_)) remove(cellOf(entry.key), entry, unpackPage(entry.packed));
    oldest_ += static_cast<Place>(entry.size());
  }
  moveUp();
}

// Moves what is used to the front of the log once an eighth is not, and gives the rest back.
void NodeMemory::moveUp() {
  if (8 * unused_ < log_.size() + kFewBytes) return;
  size_t end = 0;
  for (Place place = oldest_; place < log_.size();) {
    const Entry entry = entryAt(place);
    const size_t size = entry.size();
    if (const size_t cell = count_ > 0 ? cellOf(entry.key) : 0; count_ > 0 && cells_[cell] == place) {
      std::copy_n(log_.begin() + place, size, log_.begin() + static_cast<std::ptrdiff_t>(end));
      cells_[cell] = static_cast<Place>(end);
      end += size;
    }
    place += static_cast<Place>(size);
  }
  log_.resize(end);
  if (log_.capacity() > end + end / 8 + kFewBytes) log_.shrink_to_fit();
  if (8 * count_ < 3 * cells_.size()) makeCells(2 * count_);
  oldest_ = 0;
  unused_ = 0;
}

size_t NodeMemory::cellOf(uint64_t key) const {
  size_t cell = home(key);
  while (cells_[cell] != kNowhere && entryAt(cells_[cell]).key != key) cell = next(cell);
  return cell;
}

void NodeMemory::makeCells(size_t count) {
  std::vector<Place> old(std::max(count, kFewCells), kNowhere);
  std::swap(old, cells_);
  for (Place place : old)
    if (place != kNowhere) cells_[cellOf(entryAt(place).key)] = place;
}

// Cells after the freed one move up where their chains passed over it (Knuth, TAOCP 3, 6.4, algorithm R).
void NodeMemory::freeCell(size_t cell) {
  const auto distance = [this](size_t from, size_t to) { return to >= from ? to - from : to + cells_.size() - from; };
  size_t hole = cell;
  for (size_t at = next(hole); cells_[at] != kNowhere; at = next(at)) {
    const size_t from = home(entryAt(cells_[at]).key);
    if (distance(from, at) < distance(hole, at)) continue;
    cells_[hole] = cells_[at];
    hole = at;
  }
  cells_[hole] = kNowhere;
}

}  // namespace foreland::proto
