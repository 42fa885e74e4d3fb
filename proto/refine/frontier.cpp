#include "proto/refine/frontier.h"

#include <algorithm>
#include <cstring>
#include <numeric>

#include "base/check.h"

namespace foreland::proto {

namespace {

constexpr size_t kFew = 1024;

// Grows by an eighth, for a session's memory is counted.
template <class T>
void reserveMore(std::vector<T>& v, size_t more) {
  if (v.size() + more > v.capacity()) v.reserve(v.size() + more + 64 + v.size() / 8);
}

bool isBefore(const Frontier::PageName& a, const Frontier::PageName& b) { return a.key < b.key; }

}  // namespace

uint32_t Frontier::makePage(Slot slot, QuantisedRadius radius) {
  const uint32_t key = slot >> 8;
  if (2 * (order_.size() + fresh_.size() + 1) > cells_.size()) grow();
  const uint32_t cell = probe(key);
  CHECK_EQ(cells_[cell].page, kNone);
  if (free_.empty()) {
    reserveMore(pages_, 1);
    free_.push_back(pageCount());
    pages_.emplace_back();
  }
  const uint32_t number = free_.back();
  free_.pop_back();
  pages_[number] = {};
  pages_[number].key = key;
  pages_[number].radius = radius;
  cells_[cell] = {key, number};
  fresh_.push_back({key, number});
  return number;
}

// Merged from the back, in place.
void Frontier::orderPages() {
  std::sort(fresh_.begin(), fresh_.end(), isBefore);
  size_t left = order_.size();
  reserveMore(order_, fresh_.size());
  order_.resize(left + fresh_.size());
  for (; !fresh_.empty(); fresh_.pop_back()) {
    for (; left > 0 && isBefore(fresh_.back(), order_[left - 1]); --left)
      order_[left + fresh_.size() - 1] = order_[left - 1];
    order_[left + fresh_.size() - 1] = fresh_.back();
  }
}

std::span<const Frontier::PageName> Frontier::pagesOf(Slot begin, Slot end) const {
  const auto from = [this](Slot slot) {
    return std::lower_bound(order_.begin(), order_.end(), PageName{slot >> 8, 0}, isBefore);
  };
  return {from(begin), from(end)};
}

void Frontier::setInSection(uint32_t number, uint8_t low, bool value) {
  Page& page = pages_[number];
  if (value) return page.in_section.set(low);
  page.in_section.clear(low);
  if (page.isEmpty()) empty_.push_back(number);
}

void Frontier::list(uint32_t number, uint8_t low, QuantisedError bound, float slack, uint16_t constraint) {
  Page& page = pages_[number];
  const uint32_t at = page.on_frontier.countBefore(low);
  const Entry entry = Entry::of(low, bound, constraint);
  if (page.on_frontier.has(low)) {
    pool_.slack(page.block)[at] = slack;
    pool_.entries(page.block)[at] = entry;
    return;
  }
  pool_.insert(page.block, page.count, at, slack, entry);
  page.on_frontier.set(low);
  ++page.count;
  ++entries_;
}

void Frontier::unlist(uint32_t number, uint8_t low) {
  Page& page = pages_[number];
  page.on_frontier.clear(low);
  pool_.erase(page.block, page.count, page.on_frontier.countBefore(low));
  --page.count;
  --entries_;
  if (page.isEmpty()) empty_.push_back(number);
}

namespace {

// Pays for whole vectors. Whether any slack is below zero.
bool pay(const MotionBound& motion, float* slack, const Entry* entries, size_t vectors) {
  const auto [fixed0, fixed1, fixed2, fixed3] = motion.fixed;
  const auto [per_distance0, per_distance1, per_distance2, per_distance3] = motion.per_distance;
  uint32_t all_bits = 0;
  for (size_t i = 0; i < vectors * EntryPool::kVector; ++i) {
    const bool is_odd = (entries[i].sensitivity() & 1) != 0, is_high = (entries[i].sensitivity() & 2) != 0;
    const float fixed = is_high ? (is_odd ? fixed3 : fixed2) : is_odd ? fixed1 : fixed0;
    const float per_distance = is_high  ? (is_odd ? per_distance3 : per_distance2)
                               : is_odd ? per_distance1
                                        : per_distance0;
    const float left = slack[i] - (fixed + per_distance * entries[i].max_distance());
    all_bits |= std::bit_cast<uint32_t>(left);
    slack[i] = left;
  }
  return (all_bits & 0x80000000) != 0;  // the sign of any
}

// Of a vector of slacks, those below zero: bit i for entry 2 i, bit 32 + i for entry 2 i + 1.
uint64_t signs(const float* slack) {
  static_assert(std::endian::native == std::endian::little && EntryPool::kVector == 8);
  uint64_t signs = 0;
  for (int i = 0; i < 4; ++i) {
    uint64_t two;
    std::memcpy(&two, slack + 2 * i, sizeof two);
    signs |= (two & 0x80000000'80000000) >> (31 - i);
  }
  return signs;
}

}  // namespace

// A slack of nothing is used up by any motion, for a motion is never nothing.
uint32_t Frontier::consume(const MotionBound& motion, Page& page, std::array<uint32_t, kPageSlots>& places) {
  constexpr uint32_t kVector = EntryPool::kVector;
  if (motion.isUnbounded()) {
    std::iota(places.begin(), places.begin() + page.count, page.block.first);
    return page.count;
  }
  float* slack = pool_.slack(page.block);
  if (!pay(motion, slack, pool_.entries(page.block), (page.count + kVector - 1) / kVector)) return 0;
  uint32_t count = 0;
  for (uint32_t begin = 0; begin < page.count; begin += kVector)
    for (uint64_t left = signs(slack + begin); left != 0; left &= left - 1) {
      const uint32_t bit = static_cast<uint32_t>(std::countr_zero(left));
      places[count++] = page.block.first + begin + 2 * (bit & 31) + (bit >> 5);
    }
  return count;
}

void Frontier::endStep() {
  dropEmpty();
  if (pool_.capacity() > 2 * pool_.held() + kFew || pages_.capacity() > 2 * order_.size() + kFew) compact();
}

void Frontier::dropEmpty() {
  if (empty_.empty()) return;
  for (uint32_t number : empty_) {
    const uint32_t cell = probe(pages_[number].key);
    if (cells_[cell].page == number && pages_[number].isEmpty()) erase(cell);
  }
  empty_.clear();
  std::erase_if(order_, [this](const PageName& name) { return cells_[probe(name.key)].page != name.number; });
}

void Frontier::grow() {
  cells_.assign(cells_.size() * 2, {});
  --shift_;
  for (const auto* names : {&order_, &fresh_})
    for (const PageName& name : *names) cells_[probe(name.key)] = {name.key, name.number};
}

// Cells after the freed one move up where their chains passed over it.
void Frontier::erase(uint32_t cell) {
  free_.push_back(cells_[cell].page);
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

void Frontier::compact() {
  EntryPool pool(pool_.held() + pool_.held() / 8);
  std::vector<Page> pages;
  pages.reserve(order_.size() + order_.size() / 8);
  for (PageName& name : order_) {
    Page& page = pages.emplace_back(pages_[name.number]);
    page.block = pool.copy(pool_, page.block, page.count);
    name.number = static_cast<uint32_t>(pages.size() - 1);
  }
  pool_ = std::move(pool);
  pages_ = std::move(pages);
  free_.clear();
  cells_.assign(cells_.size(), {});
  for (const PageName& name : order_) cells_[probe(name.key)] = {name.key, name.number};
}

size_t Frontier::bytes() const {
  return cells_.capacity() * sizeof(Cell) + pages_.capacity() * sizeof(Page) + order_.capacity() * sizeof(PageName) +
         fresh_.capacity() * sizeof(PageName) + (free_.capacity() + empty_.capacity()) * sizeof(uint32_t) +
         pool_.bytes();
}

void Frontier::validate() const {
  size_t entries = 0;
  for (size_t i = 0; i < order_.size(); ++i) {
    if (i > 0) CHECK_LT(order_[i - 1].key, order_[i].key);
    CHECK_EQ(find(order_[i].key << 8), order_[i].number);
    const Page& page = pages_[order_[i].number];
    CHECK_EQ(page.key, order_[i].key);
    CHECK_TRUE(!page.isEmpty());
    CHECK_EQ(page.count, page.on_frontier.count());
    CHECK_LE(page.count, EntryPool::kSizes[page.block.size]);
    uint32_t at = 0;
    page.on_frontier.forEach([&](uint8_t low) { CHECK_EQ(pool_.entries(page.block)[at++].low(), low); });
    entries += page.count;
  }
  CHECK_EQ(entries, entries_);
}

}  // namespace foreland::proto
