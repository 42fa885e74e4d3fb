#include "proto/refine/frontier.h"

#include <algorithm>

#include "base/bit_instructions.h"
#include "base/check.h"
#include "proto/refine/take_motion.h"

namespace foreland::proto {

namespace {

// Compacting leaves room for an eighth more, as growing does; another eighth is left for what comes and goes.
bool isWasteful(size_t capacity, size_t of_use) {
  constexpr size_t kFew = 1024;
  return 4 * capacity > 5 * of_use + kFew;
}

}  // namespace

uint32_t Frontier::makePage(Slot slot, const PageKnowledge& knowledge) {
  const uint32_t number = nodes_.makePage(slot);
  nodes_.page(number).knowledge = knowledge;
  return number;
}

void Frontier::put(uint32_t number, FrontierEntry entry, float slack) {
  if (!page(number).on_frontier.has(entry.low())) enter(number, SlotBits::of(entry.low()), entry);
  renew(firstEntry(number) + page(number).on_frontier.countBefore(entry.low()), entry, slack);
}

void Frontier::enter(uint32_t number, const SlotBits& nodes, FrontierEntry blank) {
  if (!nodes.any()) return;
  runWithBitInstructions([&]() FORELAND_WITH_BIT_INSTRUCTIONS {
    uint32_t more = nodes.count();
    Page& page = nodes_.page(number);
    pool_.reserve(page.block, page.entries, page.entries + more);
    float* slack = pool_.slack(page.block);
    FrontierEntry* entries = pool_.entries(page.block);
    uint32_t end = page.entries;
    page.entries = static_cast<uint16_t>(end + more);
    entries_ += more;
    // From the back, so that each of the others moves once.
    const FrontierEntry entry = blank;
    const SlotBits others = page.on_frontier;
    nodes.forEachDescending([&](uint8_t low) {
      for (const uint32_t begin = others.countBefore(low); end > begin; --end) {
        slack[end - 1 + more] = slack[end - 1];
        entries[end - 1 + more] = entries[end - 1];
      }
      --more;
      slack[end + more] = 0;
      entries[end + more] = entry.at(low);
    });
  });
  nodes_.addToFrontier(number, nodes);
}

void Frontier::leave(uint32_t number, const SlotBits& nodes) {
  runWithBitInstructions([&]() FORELAND_WITH_BIT_INSTRUCTIONS {
    Page& page = nodes_.page(number);
    float* slack = pool_.slack(page.block);
    FrontierEntry* entries = pool_.entries(page.block);
    uint32_t gone = 0, at = 0;
    const auto moveUpTo = [&](uint32_t end) {
      for (; gone > 0 && at < end; ++at) {
        slack[at - gone] = slack[at];
        entries[at - gone] = entries[at];
      }
    };
    nodes.forEachRanked(page.on_frontier, [&](uint8_t, uint32_t rank) {
      moveUpTo(rank);
      at = rank + 1;
      ++gone;
    });
    moveUpTo(page.entries);
    const uint32_t left = page.entries - gone;
    std::fill(slack + left, slack + page.entries, EntryPool::kEndless);
    page.entries = static_cast<uint16_t>(left);
    entries_ -= gone;
    pool_.shrink(page.block, left);
  });
  nodes_.removeFromFrontier(number, nodes);
}

// A slack of zero is always used up, for MotionBound::set() makes every motion positive.
SlotBits Frontier::consume(const MotionBound& motion, const Page& page) {
  if (motion.isUnbounded()) return SlotBits::below(page.entries);
  return takeMotion(motion, pool_.slack(page.block), pool_.entries(page.block), page.entries);
}

void Frontier::compact() {
  if (!isWasteful(pool_.capacity(), pool_.held()) && !isWasteful(nodes_.capacity(), nodes_.size())) return;
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
