#include "proto/refine/frontier.h"

#include <algorithm>
#include <bit>
#include <utility>

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
  blocks_.reserve(nodes_.capacity());
  blocks_.resize(nodes_.pageCount());
  blocks_[number] = {};
  setKnowledge(number, knowledge);
  return number;
}

void Frontier::put(uint32_t number, FrontierEntry entry) {
  if (!page(number).on_frontier.has(entry.low())) enter(number, SlotBits::of(entry.low()), entry);
  renew(number, page(number).on_frontier.countBefore(entry.low()), entry);
}

namespace {

// Both columns of a block. Not templates of what the second holds: a compiler that is asked for speed takes the
// question out of the loops, one that is asked for a small module does not.
class Columns {
 public:
  Columns(EntryPool& pool, const EntryBlock& block)
      : bits_(pool.bits(block)),
        slacks_(pool.slacks(block)),
        heights_(pool.heights(block)),
        is_swept_(pool.kind() == EntryKind::kSwept) {}

  FORELAND_WITH_BIT_INSTRUCTIONS void copy(uint32_t from, uint32_t to) const {
    bits_[to] = bits_[from];
    if (is_swept_)
      heights_[to] = heights_[from];
    else
      slacks_[to] = slacks_[from];
  }
  FORELAND_WITH_BIT_INSTRUCTIONS void set(uint32_t at, FrontierEntry entry) const {
    bits_[at] = entry.bits;
    if (is_swept_)
      heights_[at] = static_cast<uint8_t>(entry.rest);
    else
      slacks_[at] = entry.rest;
  }

 private:
  uint32_t *bits_, *slacks_;
  uint8_t* heights_;
  bool is_swept_;
};

// From the back, so that each of the others moves once.
FORELAND_WITH_BIT_INSTRUCTIONS inline void insertEntries(const SlotBits& old, const SlotBits& nodes, uint32_t more,
                                                         uint32_t end, FrontierEntry blank, const Columns columns) {
  uint32_t before = end;  // of the old entries
  for (uint32_t w = 4; w-- > 0;) {
    const uint64_t old_word = old.words[w];
    before -= static_cast<uint32_t>(std::popcount(old_word));
    for (uint64_t word = nodes.words[w]; word != 0;) {
      const uint32_t top = 63 - static_cast<uint32_t>(std::countl_zero(word));
      const uint64_t bit = uint64_t{1} << top;
      word ^= bit;
      for (const uint32_t begin = before + static_cast<uint32_t>(std::popcount(old_word & (bit - 1))); end > begin;
           --end)
        columns.copy(end - 1, end - 1 + more);
      --more;
      columns.set(end + more, blank.at(static_cast<uint8_t>(w << 6 | top)));
    }
  }
}

// How many have gone.
FORELAND_WITH_BIT_INSTRUCTIONS inline uint32_t eraseEntries(const SlotBits& old, const SlotBits& nodes, uint32_t count,
                                                            const Columns columns) {
  uint32_t gone = 0, at = 0;
  const auto moveUpTo = [&](uint32_t end) {
    for (; gone > 0 && at < end; ++at) columns.copy(at, at - gone);
  };
  nodes.forEachRanked(old, [&](uint8_t, uint32_t rank) {
    moveUpTo(rank);
    at = rank + 1;
    ++gone;
  });
  moveUpTo(count);
  return gone;
}

}  // namespace

void Frontier::enter(uint32_t number, const SlotBits& nodes, FrontierEntry blank) {
  if (!nodes.any()) return;
  runWithBitInstructions([&]() FORELAND_WITH_BIT_INSTRUCTIONS {
    const uint32_t more = nodes.count();
    EntryBlock& block = blocks_[number];
    const uint32_t end = block.count;
    pool_.reserve(block, end + more);
    const SlotBits& old = page(number).on_frontier;
    insertEntries(old, nodes, more, end, blank, Columns(pool_, block));
    block.count = static_cast<uint16_t>(end + more);
    entries_ += more;
  });
  nodes_.addToFrontier(number, nodes);
}

void Frontier::leave(uint32_t number, const SlotBits& nodes) {
  runWithBitInstructions([&]() FORELAND_WITH_BIT_INSTRUCTIONS {
    EntryBlock& block = blocks_[number];
    const SlotBits& old = page(number).on_frontier;
    const uint32_t gone = eraseEntries(old, nodes, block.count, Columns(pool_, block));
    block.count = static_cast<uint16_t>(block.count - gone);
    entries_ -= gone;
    pool_.shrink(block);
  });
  nodes_.removeFromFrontier(number, nodes);
}

// A slack of zero is always used up, for MotionBound::set() makes every motion positive.
SlotBits Frontier::consume(const MotionBound& motion, const EntryBlock& block) {
  const SlotBits there = SlotBits::below(block.count);
  return motion.isUnbounded() ? there : takeMotion(motion, pool_.slacks(block), pool_.bits(block), block.count) & there;
}

void Frontier::compact() {
  if (!isWasteful(pool_.capacity(), pool_.held()) && !isWasteful(nodes_.capacity(), nodes_.size())) return;
  // Copies take less than is held now; with memory for that, the next step would find a quarter too much again.
  size_t held = 0;
  for (const Nodes::PageName& name : nodes_.pages()) held += EntryPool::heldByCopy(blocks_[name.number]);
  EntryPool pool(pool_.kind(), held + held / 8);
  std::vector<EntryBlock> blocks;
  blocks.reserve(nodes_.compactCapacity());
  blocks.emplace_back();
  for (const Nodes::PageName& name : nodes_.pages()) blocks.push_back(pool.copy(pool_, blocks_[name.number]));
  nodes_.compact();
  blocks_ = std::move(blocks);
  pool_ = std::move(pool);
}

void Frontier::validate() const {
  nodes_.validate();
  size_t entries = 0;
  for (const Nodes::PageName& name : nodes_.pages()) {
    const EntryBlock& block = blocks_[name.number];
    CHECK_EQ(block.count, page(name.number).on_frontier.count());
    CHECK_LE(block.count, EntryPool::kSizes[block.size]);
    CHECK_EQ(block.radius.value, page(name.number).knowledge.radius.value);
    uint32_t at = 0;
    page(name.number).on_frontier.forEach([&](uint8_t low) { CHECK_EQ(pool_.at(block, at++).low(), low); });
    entries += block.count;
  }
  CHECK_EQ(entries, entries_);
}

}  // namespace foreland::proto
