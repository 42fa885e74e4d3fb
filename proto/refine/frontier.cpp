#include "proto/refine/frontier.h"

#include <cstring>
#include <numeric>

#include "base/check.h"

namespace foreland::proto {

namespace {

constexpr size_t kFew = 1024;

}  // namespace

uint32_t Frontier::makePage(Slot slot, const PageKnowledge& knowledge) {
  const uint32_t number = nodes_.makePage(slot);
  nodes_.page(number).knowledge = knowledge;
  return number;
}

void Frontier::put(uint32_t number, FrontierEntry entry, float slack) {
  Page& page = nodes_.page(number);
  const uint32_t at = page.on_frontier.countBefore(entry.low());
  if (page.on_frontier.has(entry.low())) {
    pool_.slack(page.block)[at] = slack;
    pool_.entries(page.block)[at] = entry;
    return;
  }
  pool_.insert(page.block, page.entries, at, slack, entry);
  nodes_.addToFrontier(number, entry.low());
  ++page.entries;
  ++entries_;
}

void Frontier::remove(uint32_t number, uint8_t low) {
  Page& page = nodes_.page(number);
  pool_.erase(page.block, page.entries, page.on_frontier.countBefore(low));
  nodes_.removeFromFrontier(number, low);
  --page.entries;
  --entries_;
}

namespace {

// Takes the motion off whole vectors of slacks. Whether any is below zero then.
bool subtract(const MotionBound& motion, float* slack, const FrontierEntry* entries, size_t vectors) {
  const auto [fixed0, fixed1, fixed2, fixed3] = motion.fixed;
  const auto [per_distance0, per_distance1, per_distance2, per_distance3] = motion.per_distance;
  uint32_t all_bits = 0;
  for (size_t i = 0; i < vectors * EntryPool::kVector; ++i) {
    const bool is_odd = (entries[i].sensitivity() & 1) != 0, is_high = (entries[i].sensitivity() & 2) != 0;
    const float fixed = is_high ? (is_odd ? fixed3 : fixed2) : is_odd ? fixed1 : fixed0;
    const float per_distance = is_high  ? (is_odd ? per_distance3 : per_distance2)
                               : is_odd ? per_distance1
                                        : per_distance0;
    const float left = slack[i] - (fixed + per_distance * entries[i].maxDistance());
    all_bits |= std::bit_cast<uint32_t>(left);
    slack[i] = left;
  }
  return (all_bits & 0x80000000) != 0;  // the sign of any
}

// The signs of a vector of slacks: bit i is that of entry 2 i, bit 32 + i that of entry 2 i + 1.
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

// A slack of zero is always used up, for MotionBound::set() makes every motion positive.
uint32_t Frontier::consume(const MotionBound& motion, const Page& page, std::array<uint32_t, kPageSlots>& stale) {
  constexpr uint32_t kVector = EntryPool::kVector;
  if (motion.isUnbounded()) {
    std::iota(stale.begin(), stale.begin() + page.entries, page.block.first);
    return page.entries;
  }
  float* slack = pool_.slack(page.block);
  if (!subtract(motion, slack, pool_.entries(page.block), (page.entries + kVector - 1) / kVector)) return 0;
  uint32_t count = 0;
  for (uint32_t begin = 0; begin < page.entries; begin += kVector)
    for (uint64_t left = signs(slack + begin); left != 0; left &= left - 1) {
      const uint32_t bit = static_cast<uint32_t>(std::countr_zero(left));
      stale[count++] = page.block.first + begin + 2 * (bit & 31) + (bit >> 5);
    }
  return count;
}

void Frontier::compact() {
  if (pool_.capacity() <= 2 * pool_.held() + kFew && nodes_.capacity() <= 2 * nodes_.size() + kFew) return;
  EntryPool pool(pool_.held() + pool_.held() / 8);
  nodes_.compact([&](Page& page) { page.block = pool.copy(pool_, page.block, page.entries); });
  pool_ = std::move(pool);
}

void Frontier::validate() const {
  nodes_.validate();
  size_t entries = 0;
  for (const Nodes::PageName& name : nodes_.pages()) {
    const Page& page = nodes_.page(name.number);
    CHECK_EQ(page.entries, page.on_frontier.count());
    CHECK_LE(page.entries, EntryPool::kSizes[page.block.size]);
    uint32_t at = 0;
    page.on_frontier.forEach([&](uint8_t low) { CHECK_EQ(pool_.entries(page.block)[at++].low(), low); });
    entries += page.entries;
  }
  CHECK_EQ(entries, entries_);
}

}  // namespace foreland::proto
