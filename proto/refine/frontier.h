// A section and its frontier as an adapter keeps them: for each slot, is the node active, and is it on the frontier
// (removable or addable) with an entry that says what is known of it and how long its last test is sure to hold. In
// pages of 256 slots (a tile of the slot order, so neighbours share a page); a page lives until a step leaves it empty.
// One owner. A look-up is one probe of a small hash table; no allocation once grown to the section's size.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <span>
#include <vector>

#include "proto/bounds.h"
#include "proto/refine/metric.h"

namespace foreland::proto {

class Frontier {
 public:
  enum Flag : uint32_t { kActive, kListed };

  // What is known of a frontier node's error: that it is at least `bound` if the node is active, at most if it is not.
  struct Entry {
    float slack = 0;  // how much of it is left (Metric::Outcome), metres
    uint8_t low = 0;  // slot within the page
    ErrorClass bound;
    uint16_t reach = 0;  // packReach()
  };
  static_assert(sizeof(Entry) == 8);

  // The largest distance from the eye while the slack lasts, rounded up to six bits, and the guard.
  static uint16_t packReach(float reach_m, uint8_t guard) {
    return static_cast<uint16_t>((((std::bit_cast<uint32_t>(reach_m) + 0x1ffff) >> 17) << 2) | guard);
  }
  static float reachOf(uint16_t packed) { return std::bit_cast<float>(static_cast<uint32_t>(packed >> 2) << 17); }
  static uint32_t guardOf(uint16_t packed) { return packed & 3u; }

  bool isActive(Slot slot) const { return get(kActive, slot); }
  bool isListed(Slot slot) const { return get(kListed, slot); }
  bool hasPage(Slot slot) const { return cells_[probe(slot >> 8)].page != kNone; }
  // Of the slot's page, which is made if it is not there.
  RadiusClass radius(Slot slot) const { return pages_[cells_[probe(slot >> 8)].page].radius; }
  void makePage(Slot slot, RadiusClass radius);

  // The slot's page must be there for all of these.
  void setActive(Slot slot, bool value);
  void list(Slot slot, ErrorClass bound, float slack, uint16_t reach);  // anew, or instead of its entry
  void unlist(Slot slot);                                               // if it is listed

  // An entry that is due; where it is holds until the next list() or unlist() of another slot.
  struct Due {
    Slot slot;
    uint32_t page;
    uint8_t entry;
    ErrorClass bound;
    RadiusClass radius;
    bool is_active;
  };
  void renew(const Due& due, float slack, uint16_t reach) {
    Page& page = pages_[due.page];
    Entry& entry = pool_[page.first + due.entry];
    entry.slack = slack;
    entry.reach = reach;
    page.least_slack = std::min(page.least_slack, slack);
    page.most_reach = std::max(page.most_reach, reachOf(reach));
  }
  // Takes the toll of a step off every slack; appends the entries whose slack is used up, page by page.
  void takeOff(const Metric::Toll& toll, std::vector<Due>& due);
  // Drops the pages that have become empty.
  void endStep();

  // Calls `visit(slot)` for each slot with the flag, in no particular order.
  template <class Visit>
  void forEach(Flag flag, const Visit& visit) const {
    for (const Page& page : pages_)
      for (uint32_t w = 0; w < 4; ++w)
        for (uint64_t bits = page.bits[flag][w]; bits != 0; bits &= bits - 1)
          visit(page.key << 8 | w << 6 | static_cast<uint32_t>(std::countr_zero(bits)));
  }

  size_t entryCount() const { return entries_; }
  size_t bytes() const;

 private:
  static constexpr uint32_t kNone = 0xffffffffu;
  static constexpr uint32_t kRoom = 4;  // entries; rooms are multiples of it

  struct Page {
    uint32_t key = 0;        // slot >> 8
    uint32_t first = kNone;  // of its entries in the pool
    uint16_t count = 0;      // entries
    uint8_t rooms = 0;       // of kRoom entries each
    RadiusClass radius;
    float least_slack = 0, most_reach = 0;                // over the entries, once what is owed has been paid
    std::array<float, 3> owed_fixed{}, owed_per_reach{};  // tolls not yet taken off its entries
    std::array<std::array<uint64_t, 4>, 2> bits{};        // by flag
  };
  struct Cell {
    uint32_t key = 0;
    uint32_t page = kNone;
  };

  bool get(Flag flag, Slot slot) const {
    const uint32_t page = cells_[probe(slot >> 8)].page;
    return page != kNone && (pages_[page].bits[flag][slot >> 6 & 3] >> (slot & 63) & 1);
  }
  uint32_t home(uint32_t key) const { return (key * 0x9e3779b1u) >> shift_; }
  uint32_t mask() const { return static_cast<uint32_t>(cells_.size() - 1); }
  // Cell of the page with this key, or the empty cell where it would be.
  uint32_t probe(uint32_t key) const {
    uint32_t at = home(key);
    while (cells_[at].key != key && cells_[at].page != kNone) at = (at + 1) & mask();
    return at;
  }
  std::span<Entry> entriesOf(const Page& page) { return {pool_.data() + page.first, page.count}; }
  static bool isEmpty(const Page& page) {
    uint64_t any = 0;
    for (const auto& flag : page.bits)
      for (uint64_t word : flag) any |= word;
    return any == 0;
  }
  void pay(Page& page, std::vector<Due>* due);
  void makeRoom(Page& page);
  void freeRoom(Page& page);
  void grow();
  void erase(uint32_t cell);

  std::vector<Cell> cells_ = std::vector<Cell>(64);  // power of two, open addressing; an empty cell's key says nothing
  uint32_t shift_ = 26;
  std::vector<Page> pages_;      // dense
  std::vector<uint32_t> empty_;  // keys of pages that have become empty in this step, perhaps not for good
  std::vector<Entry> pool_;
  std::array<std::vector<uint32_t>, kPageSlots / kRoom + 1> free_;  // by number of rooms
  size_t entries_ = 0;
};

}  // namespace foreland::proto
