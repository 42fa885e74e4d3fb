// A section and its frontier as two sets of slots: which nodes are in the section, and which are on its frontier
// (leaves, which can be removed, and nodes outside of it that can be added). In pages of kPageSlots slots, a tile of
// the slot order, so neighbours share a page; a page lives while it holds something. What an owner keeps beside the two
// sets of a page stands in its own Page, derived from NodePage.
//
// Pages have numbers, which hold until the page is dropped or compact(); number 0 is a page that is always empty and
// stands for all pages that are not there. One owner. A page is found by one probe of an IndexTable; no allocation once
// grown to the section's size.
#pragma once

#include <algorithm>
#include <bit>
#include <cstdint>
#include <span>
#include <type_traits>
#include <utility>
#include <vector>

#include "base/check.h"
#include "base/sort.h"
#include "proto/refine/memory/slot_bits.h"
#include "proto/section/index_table.h"
#include "proto/topology/node.h"

namespace foreland::proto {

struct NodePage {
  SlotBits in_section, on_frontier;
  uint32_t key = 0;  // slot / kPageSlots

  Slot first() const { return key * kPageSlots; }
  bool isEmpty() const { return !in_section.any() && !on_frontier.any(); }
};

// The index of a slot in its page.
inline uint8_t lowOf(Slot slot) {
  static_assert(kPageSlots == 256);
  return static_cast<uint8_t>(slot);
}

template <class Page>
class PagedNodes {
  static_assert(std::is_base_of_v<NodePage, Page>);

 public:
  static constexpr uint32_t kNone = IndexTable::kNone;

  // The number of the slot's page; kNone if it is not there.
  uint32_t find(Slot slot) const { return numbers_.find(slot / kPageSlots); }
  const Page& page(uint32_t number) const { return pages_[number]; }
  const Page& pageAt(Slot slot) const { return pages_[find(slot)]; }
  // For what the owner keeps in a page; its sets are changed by the functions below.
  Page& page(uint32_t number) { return pages_[number]; }
  // One past the largest number.
  uint32_t pageCount() const { return static_cast<uint32_t>(pages_.size()); }
  size_t capacity() const { return pages_.capacity(); }
  size_t size() const { return order_.size() + fresh_.size(); }

  // Makes the slot's page, which must not be there, and returns its number. It is one of pages() after orderPages().
  uint32_t makePage(Slot slot) {
    const uint32_t key = slot / kPageSlots;
    CHECK_EQ(numbers_.find(key), kNone);
    if (free_.empty()) {
      reserveMore(pages_, 1);
      free_.push_back(pageCount());
      pages_.emplace_back();
    }
    const uint32_t number = free_.back();
    free_.pop_back();
    pages_[number] = {};
    pages_[number].key = key;
    numbers_.insert(key, number);
    fresh_.push_back({key, number});
    return number;
  }

  struct PageName {
    uint32_t key, number;
  };
  // Sorts new pages in among the others, in place from the back.
  void orderPages() {
    foreland::sort(fresh_.begin(), fresh_.end(), isBefore);
    size_t left = order_.size();
    reserveMore(order_, fresh_.size());
    order_.resize(left + fresh_.size());
    for (; !fresh_.empty(); fresh_.pop_back()) {
      for (; left > 0 && isBefore(fresh_.back(), order_[left - 1]); --left)
        order_[left + fresh_.size() - 1] = order_[left - 1];
      order_[left + fresh_.size() - 1] = fresh_.back();
    }
  }
  // All pages, ascending; until the next call of orderPages(), dropEmpty() or compact().
  std::span<const PageName> pages() const { return order_; }
  // Those of the slots from `begin` to `end`, which must be multiples of kPageSlots.
  std::span<const PageName> pagesOf(Slot begin, Slot end) const {
    const auto from = [this](Slot slot) {
      return std::lower_bound(order_.begin(), order_.end(), PageName{slot / kPageSlots, 0}, isBefore);
    };
    return {from(begin), from(end)};
  }

  bool isInSection(Slot slot) const { return pageAt(slot).in_section.has(lowOf(slot)); }
  bool isOnFrontier(Slot slot) const { return pageAt(slot).on_frontier.has(lowOf(slot)); }
  // Whether any of the 64 slots from `first` on, a multiple of 64, is in the section or on its frontier.
  bool hasAnyOf64(Slot first) const {
    const Page& page = pageAt(first);
    const uint32_t word = first % kPageSlots / 64;
    return (page.in_section.words[word] | page.on_frontier.words[word]) != 0;
  }

  void addToSection(uint32_t number, uint8_t low) { pages_[number].in_section.set(low); }
  void removeFromSection(uint32_t number, uint8_t low) {
    pages_[number].in_section.clear(low);
    noteIfEmpty(number);
  }
  void addToFrontier(uint32_t number, uint8_t low) { pages_[number].on_frontier.set(low); }
  void removeFromFrontier(uint32_t number, uint8_t low) { removeFromFrontier(number, SlotBits::of(low)); }
  // Some of a page at once.
  void addToSection(uint32_t number, const SlotBits& nodes) {
    pages_[number].in_section = pages_[number].in_section | nodes;
  }
  void removeFromSection(uint32_t number, const SlotBits& nodes) {
    pages_[number].in_section = pages_[number].in_section - nodes;
    noteIfEmpty(number);
  }
  void addToFrontier(uint32_t number, const SlotBits& nodes) {
    pages_[number].on_frontier = pages_[number].on_frontier | nodes;
  }
  void removeFromFrontier(uint32_t number, const SlotBits& nodes) {
    pages_[number].on_frontier = pages_[number].on_frontier - nodes;
    noteIfEmpty(number);
  }

  // Calls visit(slot) for each slot in the section, or on the frontier, ascending.
  template <class Visit>
  void forEachInSection(const Visit& visit) const {
    for (const PageName& name : order_)
      pages_[name.number].in_section.forEach([&](uint8_t low) { visit(name.key * kPageSlots | low); });
  }
  template <class Visit>
  void forEachOnFrontier(const Visit& visit) const {
    for (const PageName& name : order_)
      pages_[name.number].on_frontier.forEach([&](uint8_t low) { visit(name.key * kPageSlots | low); });
  }
  // Calls visit(slot) for one in `every` of the slots in the section, ascending and evenly.
  template <class Visit>
  void sampleSection(uint32_t every, const Visit& visit) const {
    uint32_t skipped = every / 2;  // so many stand before the next one
    for (const PageName& name : order_)
      for (uint32_t w = 0; w < 4; ++w) {
        uint64_t bits = pages_[name.number].in_section.words[w];
        auto left = static_cast<uint32_t>(std::popcount(bits));
        for (; skipped < left; left -= skipped + 1, skipped = every - 1) {
          for (uint32_t i = 0; i < skipped; ++i) bits &= bits - 1;
          visit(name.key * kPageSlots | w << 6 | static_cast<uint32_t>(std::countr_zero(bits)));
          bits &= bits - 1;
        }
        skipped -= left;
      }
  }

  // Drops the pages that have become empty; the second after a call of dropped(page) for each, ascending.
  void dropEmpty() {
    dropEmpty([](const Page&) {});
  }
  template <class Dropped>
  void dropEmpty(const Dropped& dropped) {
    CHECK_TRUE(fresh_.empty());
    // Only pages that were noted are looked at, in the memory for new ones.
    std::vector<PageName>& gone = fresh_;
    for (uint32_t number : empty_)
      if (pages_[number].isEmpty()) gone.push_back({pages_[number].key, number});
    empty_.clear();
    if (gone.empty()) return;
    foreland::sort(gone.begin(), gone.end(), isBefore);
    gone.erase(std::unique(gone.begin(), gone.end(),
                           [](const PageName& x, const PageName& y) { return x.number == y.number; }),
               gone.end());
    size_t next = 0;
    std::erase_if(order_, [&](const PageName& name) {
      if (next == gone.size() || name.key != gone[next].key) return false;
      ++next;
      dropped(std::as_const(pages_[name.number]));
      numbers_.erase(name.key);
      free_.push_back(name.number);
      return true;
    });
    CHECK_EQ(next, gone.size());
    gone.clear();
  }
  // Numbers the pages anew, from 1 in order, in memory that fits them: that of compactCapacity() pages. All are
  // ordered.
  size_t compactCapacity() const { return 1 + order_.size() + order_.size() / 8; }
  void compact() {
    std::vector<Page> pages;
    pages.reserve(compactCapacity());
    pages.emplace_back();
    numbers_.reset(order_.size());
    for (PageName& name : order_) {
      pages.push_back(pages_[name.number]);
      name.number = static_cast<uint32_t>(pages.size() - 1);
      numbers_.insert(name.key, name.number);
    }
    pages_ = std::move(pages);
    free_.clear();
  }

  size_t bytes() const {
    return numbers_.bytes() + pages_.capacity() * sizeof(Page) +
           (order_.capacity() + fresh_.capacity()) * sizeof(PageName) +
           (free_.capacity() + empty_.capacity()) * sizeof(uint32_t);
  }
  // CHECKs that all pages are ordered, found by their keys and not empty. O(pages).
  void validate() const {
    CHECK_EQ(numbers_.size(), order_.size());
    CHECK_TRUE(fresh_.empty() && pages_[kNone].isEmpty());
    for (size_t i = 0; i < order_.size(); ++i) {
      if (i > 0) CHECK_LT(order_[i - 1].key, order_[i].key);
      CHECK_EQ(numbers_.find(order_[i].key), order_[i].number);
      CHECK_EQ(pages_[order_[i].number].key, order_[i].key);
      CHECK_TRUE(!pages_[order_[i].number].isEmpty());
    }
  }

 private:
  static bool isBefore(const PageName& a, const PageName& b) { return a.key < b.key; }
  // Grows by an eighth, for a session's memory is counted.
  template <class T>
  static void reserveMore(std::vector<T>& v, size_t more) {
    if (v.size() + more > v.capacity()) v.reserve(v.size() + more + 64 + v.size() / 8);
  }
  void noteIfEmpty(uint32_t number) {
    if (pages_[number].isEmpty()) empty_.push_back(number);
  }

  IndexTable numbers_;                              // of pages, by key
  std::vector<Page> pages_ = std::vector<Page>(1);  // by number
  std::vector<uint32_t> free_;                      // numbers without a page
  std::vector<PageName> order_;                     // ascending
  std::vector<PageName> fresh_;                     // not among them yet
  std::vector<uint32_t> empty_;  // numbers of pages that have become empty since dropEmpty(), perhaps not for good
};

}  // namespace foreland::proto
