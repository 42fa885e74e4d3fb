// A section and its frontier as an adapter keeps them: for each slot, is the node active, and is it on the frontier
// (removable or addable) with an entry that says what is known of it and how long its last test is sure to hold. In
// pages of 256 slots (a tile of the slot order, so neighbours share a page); a page lives until a step leaves it empty.
// A page's entries stand in the order of its slots, so an entry is found by counting bits.
//
// One owner. A page is found by one probe of a small hash table, and its number holds while it lives. No allocation
// once grown to the section's size.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "proto/refine/entry_pool.h"
#include "proto/refine/metric.h"
#include "proto/refine/slot_bits.h"
#include "proto/section/bounds.h"

namespace foreland::proto {

class Frontier {
 public:
  static constexpr uint32_t kNone = 0xffffffffu;

  struct Page {
    uint32_t key = 0;    // slot >> 8
    uint16_t count = 0;  // entries
    QuantisedRadius radius;
    EntryPool::Block block;
    SlotBits in_section, on_frontier;

    Slot first() const { return key << 8; }
    bool isEmpty() const { return !in_section.any() && count == 0; }
  };

  // Pages by number; kNone if the slot's is not there.
  uint32_t find(Slot slot) const { return cells_[probe(slot >> 8)].page; }
  const Page& page(uint32_t number) const { return pages_[number]; }
  // One past the largest number.
  uint32_t pageCount() const { return static_cast<uint32_t>(pages_.size()); }
  // Its page must not be there. It counts among those of pagesOf() after the next orderPages().
  uint32_t makePage(Slot slot, QuantisedRadius radius);
  void orderPages();

  struct PageName {
    uint32_t key, number;
  };
  // The pages of the slots from `begin` to `end`, which must be multiples of kPageSlots; ascending.
  std::span<const PageName> pagesOf(Slot begin, Slot end) const;

  bool isInSection(Slot slot) const {
    const uint32_t number = find(slot);
    return number != kNone && pages_[number].in_section.has(static_cast<uint8_t>(slot));
  }
  bool isOnFrontier(Slot slot) const {
    const uint32_t number = find(slot);
    return number != kNone && pages_[number].on_frontier.has(static_cast<uint8_t>(slot));
  }
  // Active or listed, from `first` on, a multiple of 64.
  bool hasAnyOf64(Slot first) const {
    const uint32_t number = find(first), word = first % kPageSlots / 64;
    return number != kNone && (pages_[number].in_section.words[word] | pages_[number].on_frontier.words[word]) != 0;
  }
  // Of the slot's page, which must be there.
  QuantisedRadius radius(Slot slot) const { return pages_[find(slot)].radius; }

  void setInSection(uint32_t number, uint8_t low, bool value);
  // Makes room for more entries at once.
  void reserve(uint32_t number, uint32_t more) {
    Page& page = pages_[number];
    pool_.reserve(page.block, page.count, page.count + more);
  }
  // Anew, or instead of its entry.
  void list(uint32_t number, uint8_t low, QuantisedError bound, float slack, uint16_t constraint);
  // It is listed.
  void unlist(uint32_t number, uint8_t low);
  // Of a listed slot.
  QuantisedError bound(const Page& page, uint8_t low) const {
    return pool_.entries(page.block)[page.on_frontier.countBefore(low)].bound();
  }

  // Takes the motion of a step off every slack and calls visit(number, places) for each page with entries whose slack
  // is used up: their places in the pool, ascending, which hold until something is listed or unlisted.
  template <class Visit>
  void consume(const MotionBound& motion, const Visit& visit) {
    constexpr size_t kSoon = 8;  // pages
    std::array<uint32_t, kPageSlots> places;
    for (size_t i = 0; i < order_.size(); ++i) {
      if (i + 2 * kSoon < order_.size()) __builtin_prefetch(&pages_[order_[i + 2 * kSoon].number]);
      if (i + kSoon < order_.size()) pool_.prefetch(pages_[order_[i + kSoon].number].block);
      const uint32_t number = order_[i].number;
      if (const uint32_t count = consume(motion, pages_[number], places); count > 0)
        visit(number, std::span<const uint32_t>(places.data(), count));
    }
  }
  const Entry& entryAt(uint32_t place) const { return pool_.entryAt(place); }
  void renew(uint32_t place, float slack, uint16_t constraint) {
    pool_.slackAt(place) = slack;
    pool_.entryAt(place).setConstraint(constraint);
  }
  // Drops the pages that have become empty, and gives memory back once twice as much is held as is of use; the pages'
  // numbers end then.
  void endStep();

  // Calls `visit(slot)` for each active slot, or for each that has an entry; ascending.
  template <class Visit>
  void forEachInSection(const Visit& visit) const {
    for (const PageName& name : order_)
      pages_[name.number].in_section.forEach([&](uint8_t low) { visit(name.key << 8 | low); });
  }
  template <class Visit>
  void forEachOnFrontier(const Visit& visit) const {
    for (const PageName& name : order_)
      pages_[name.number].on_frontier.forEach([&](uint8_t low) { visit(name.key << 8 | low); });
  }

  size_t entryCount() const { return entries_; }
  size_t bytes() const;
  // CHECKs what stands above. O(pages).
  void validate() const;

 private:
  struct Cell {
    uint32_t key = 0;
    uint32_t page = kNone;
  };

  uint32_t home(uint32_t key) const { return (key * 0x9e3779b1u) >> shift_; }
  uint32_t mask() const { return static_cast<uint32_t>(cells_.size() - 1); }
  // Cell of the page with this key, or the empty cell where it would be.
  uint32_t probe(uint32_t key) const {
    uint32_t at = home(key);
    while (cells_[at].key != key && cells_[at].page != kNone) at = (at + 1) & mask();
    return at;
  }
  uint32_t consume(const MotionBound& motion, Page& page, std::array<uint32_t, kPageSlots>& places);
  void grow();
  void erase(uint32_t cell);
  void dropEmpty();
  void compact();

  std::vector<Cell> cells_ = std::vector<Cell>(64);  // power of two, open addressing; an empty cell's key says nothing
  uint32_t shift_ = 26;
  std::vector<Page> pages_;      // by number
  std::vector<uint32_t> free_;   // numbers of none
  std::vector<PageName> order_;  // ascending
  std::vector<PageName> fresh_;  // not yet among them
  std::vector<uint32_t> empty_;  // numbers of pages that have become empty in this step, perhaps not for good
  EntryPool pool_;
  size_t entries_ = 0;
};

}  // namespace foreland::proto
