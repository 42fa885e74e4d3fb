#include "proto/refine/frontier.h"

#include <algorithm>
#include <limits>

#include "base/check.h"

namespace foreland::proto {

namespace {

constexpr float kEndless = std::numeric_limits<float>::max();

// Grows by an eighth, for a session's memory is counted.
template <class T>
void reserveMore(std::vector<T>& v, size_t more) {
  if (v.size() + more > v.capacity()) v.reserve(v.size() + more + v.size() / 8);
}

}  // namespace

void Frontier::makePage(Slot slot, RadiusClass radius) {
  const uint32_t key = slot >> 8;
  if (4 * (pages_.size() + 1) > 3 * cells_.size()) grow();
  const uint32_t cell = probe(key);
  CHECK_EQ(cells_[cell].page, kNone);
  cells_[cell] = {key, static_cast<uint32_t>(pages_.size())};
  reserveMore(pages_, 64);
  Page& page = pages_.emplace_back();
  page.key = key;
  page.radius = radius;
  page.least_slack = kEndless;
}

void Frontier::setActive(Slot slot, bool value) {
  Page& page = pages_[cells_[probe(slot >> 8)].page];
  uint64_t& word = page.bits[kActive][slot >> 6 & 3];
  const uint64_t bit = uint64_t{1} << (slot & 63);
  word = value ? word | bit : word & ~bit;
  if (!value && isEmpty(page)) empty_.push_back(page.key);
}

void Frontier::list(Slot slot, ErrorClass bound, float slack, uint16_t reach) {
  Page& page = pages_[cells_[probe(slot >> 8)].page];
  if (page.owed_fixed != std::array<float, 3>{} || page.owed_per_reach != std::array<float, 3>{}) pay(page, nullptr);
  const uint8_t low = static_cast<uint8_t>(slot);
  uint64_t& word = page.bits[kListed][slot >> 6 & 3];
  const uint64_t bit = uint64_t{1} << (slot & 63);
  const Entry entry{slack, low, bound, reach};
  page.least_slack = std::min(page.least_slack, slack);
  page.most_reach = std::max(page.most_reach, reachOf(reach));
  if (word & bit) {
    const std::span<Entry> entries = entriesOf(page);
    *std::find_if(entries.begin(), entries.end(), [low](const Entry& e) { return e.low == low; }) = entry;
    return;
  }
  word |= bit;
  if (page.count == kRoom * page.rooms) makeRoom(page);
  pool_[page.first + page.count++] = entry;
  ++entries_;
}

void Frontier::unlist(Slot slot) {
  const uint32_t index = cells_[probe(slot >> 8)].page;
  if (index == kNone) return;
  Page& page = pages_[index];
  uint64_t& word = page.bits[kListed][slot >> 6 & 3];
  const uint64_t bit = uint64_t{1} << (slot & 63);
  if (!(word & bit)) return;
  word ^= bit;
  const std::span<Entry> entries = entriesOf(page);
  const uint8_t low = static_cast<uint8_t>(slot);
  *std::find_if(entries.begin(), entries.end(), [low](const Entry& e) { return e.low == low; }) = entries.back();
  --page.count;
  --entries_;
  if (isEmpty(page)) empty_.push_back(page.key);
}

void Frontier::takeOff(const Metric::Toll& toll, std::vector<Due>& due) {
  for (Page& page : pages_) {
    float most = 0;
    for (size_t g = 0; g < 3; ++g) {
      page.owed_fixed[g] += static_cast<float>(toll.fixed[g]);
      page.owed_per_reach[g] += static_cast<float>(toll.per_reach[g]);
      most = std::max(most, page.owed_fixed[g] + page.owed_per_reach[g] * page.most_reach);
    }
    if (most * 1.0001f >= page.least_slack && page.count > 0) pay(page, &due);
  }
}

// Takes off what is owed; entries that are due then are told, and count no more until they are listed again.
void Frontier::pay(Page& page, std::vector<Due>* due) {
  page.least_slack = kEndless;
  page.most_reach = 0;
  for (uint32_t i = 0; i < page.count; ++i) {
    Entry& entry = pool_[page.first + i];
    const uint32_t guard = guardOf(entry.reach);
    const float reach = reachOf(entry.reach);
    entry.slack -= page.owed_fixed[guard] + page.owed_per_reach[guard] * reach;
    page.most_reach = std::max(page.most_reach, reach);
    if (entry.slack > 0)
      page.least_slack = std::min(page.least_slack, entry.slack);
    else if (due)
      due->push_back({page.key << 8 | entry.low, static_cast<uint32_t>(&page - pages_.data()), static_cast<uint8_t>(i),
                      entry.bound, page.radius, (page.bits[kActive][entry.low >> 6] >> (entry.low & 63) & 1) != 0});
  }
  page.owed_fixed = page.owed_per_reach = {};
}

// One more room, in a place that is free or at the pool's end.
void Frontier::makeRoom(Page& page) {
  const uint8_t rooms = static_cast<uint8_t>(page.rooms + 1);
  std::vector<uint32_t>& free = free_[rooms];
  uint32_t first;
  if (free.empty()) {
    first = static_cast<uint32_t>(pool_.size());
    reserveMore(pool_, size_t{kRoom} * rooms);
    pool_.resize(pool_.size() + size_t{kRoom} * rooms);
  } else {
    first = free.back();
    free.pop_back();
  }
  if (page.rooms > 0) std::copy_n(pool_.begin() + page.first, page.count, pool_.begin() + first);
  freeRoom(page);
  page.first = first;
  page.rooms = rooms;
}

void Frontier::freeRoom(Page& page) {
  if (page.rooms > 0) free_[page.rooms].push_back(page.first);
  page.rooms = 0;
}

void Frontier::endStep() {
  for (uint32_t key : empty_) {
    const uint32_t cell = probe(key);
    if (cells_[cell].page != kNone && isEmpty(pages_[cells_[cell].page])) erase(cell);
  }
  empty_.clear();
}

void Frontier::grow() {
  cells_.assign(cells_.size() * 2, {});
  --shift_;
  for (uint32_t i = 0; i < pages_.size(); ++i) cells_[probe(pages_[i].key)] = {pages_[i].key, i};
}

// The last page takes the freed place; cells after the freed one move up where their chains passed over it.
void Frontier::erase(uint32_t cell) {
  const uint32_t freed = cells_[cell].page, last = static_cast<uint32_t>(pages_.size() - 1);
  freeRoom(pages_[freed]);
  if (freed != last) {
    cells_[probe(pages_[last].key)].page = freed;
    pages_[freed] = pages_[last];
  }
  pages_.pop_back();
  uint32_t hole = cell;
  for (uint32_t at = (cell + 1) & mask(); cells_[at].page != kNone; at = (at + 1) & mask()) {
    const uint32_t from = home(cells_[at].key);
    if (((at - from) & mask()) >= ((at - hole) & mask())) {
      cells_[hole] = cells_[at];
      hole = at;
    }
  }
  cells_[hole] = {};
}

size_t Frontier::bytes() const {
  size_t bytes = cells_.capacity() * sizeof(Cell) + pages_.capacity() * sizeof(Page) + pool_.capacity() * sizeof(Entry);
  for (const auto& free : free_) bytes += free.capacity() * sizeof(uint32_t);
  return bytes;
}

}  // namespace foreland::proto
