// A section and its frontier as an adapter keeps them (paged_nodes.h), with an entry for each frontier node
// (entry_pool.h). A page's entries stand in the order of its slots, so an entry is found by counting bits. Where they
// are stands apart from what else is known of pages, for that is all that a pass over the entries reads.
//
// One owner. No allocation once grown to the section's size.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <type_traits>
#include <vector>

#include "proto/refine/memory/entry_pool.h"
#include "proto/refine/memory/node_memory.h"
#include "proto/refine/memory/paged_nodes.h"
#include "proto/refine/metric/motion_bound.h"
#include "proto/section/bounds.h"

namespace foreland::proto {

struct FrontierPage : NodePage {
  PageKnowledge knowledge;
};

class Frontier {
 public:
  using Page = FrontierPage;
  using Nodes = PagedNodes<Page>;

  explicit Frontier(EntryKind kind) : pool_(kind) {}

  const Nodes& nodes() const { return nodes_; }
  const Page& page(uint32_t number) const { return nodes_.page(number); }

  // As PagedNodes::makePage() and orderPages().
  uint32_t makePage(Slot slot, const PageKnowledge& knowledge);
  void orderPages() { nodes_.orderPages(); }
  void addToSection(uint32_t number, uint8_t low) { nodes_.addToSection(number, low); }
  void removeFromSection(uint32_t number, uint8_t low) { nodes_.removeFromSection(number, low); }
  void addToSection(uint32_t number, const SlotBits& some) { nodes_.addToSection(number, some); }
  void removeFromSection(uint32_t number, const SlotBits& some) { nodes_.removeFromSection(number, some); }

  // Puts a node on the frontier, or replaces its entry if it is there.
  void put(uint32_t number, FrontierEntry entry);
  // Puts nodes of a page on the frontier, none of which is there, with entries as `blank` but for their slots.
  void enter(uint32_t number, const SlotBits& nodes, FrontierEntry blank);
  // Takes nodes of a page off the frontier, all of which must be there.
  void leave(uint32_t number, const SlotBits& nodes);
  // The entry of a frontier node.
  FrontierEntry entry(uint32_t number, uint8_t low) const {
    return entryAt(number, page(number).on_frontier.countBefore(low));
  }

  // Takes the motion of a step off every slack and calls visit(number, ranks) for each page with entries whose slack is
  // used up: the ranks of these among the page's entries.
  template <class Visit>
  void consume(const MotionBound& motion, const Visit& visit) {
    forEachBlock([&](uint32_t number, Slot, const EntryBlock& block) {
      if (const SlotBits ranks = consume(motion, block); ranks.any()) visit(number, ranks);
    });
  }
  // Calls visit(number, first slot, block, column of bits, column of heights) for each page with entries, ascending.
  // The frontier is swept.
  template <class Visit>
  void forEachSwept(const Visit& visit) const {
    forEachBlock([&](uint32_t number, Slot first, const EntryBlock& block) {
      visit(number, first, block, pool_.bits(block), pool_.heights(block));
    });
  }
  // Of a page's entries, by rank: FrontierEntry::bits. Until entries come or go.
  const uint32_t* entryBits(uint32_t number) const { return pool_.bits(blocks_[number]); }
  // By rank among the page's entries.
  FrontierEntry entryAt(uint32_t number, uint32_t rank) const { return pool_.at(blocks_[number], rank); }
  // Replaces the entry of the same node.
  void renew(uint32_t number, uint32_t rank, FrontierEntry entry) { pool_.set(blocks_[number], rank, entry); }
  // The same of several of the page's entries: entryOf(i) is that of the rank ranks[i].
  template <class EntryOf>
  void renew(uint32_t number, std::span<const uint8_t> ranks, const EntryOf& entryOf) {
    const EntryBlock block = blocks_[number];
    uint32_t* const bits = pool_.bits(block);
    const auto renewAll = [&](auto* rest) {
      for (size_t i = 0; i < ranks.size(); ++i) {
        const FrontierEntry entry = entryOf(i);
        bits[ranks[i]] = entry.bits;
        rest[ranks[i]] = static_cast<std::remove_reference_t<decltype(*rest)>>(entry.rest);
      }
    };
    if (pool_.kind() == EntryKind::kSwept)
      renewAll(pool_.heights(block));
    else
      renewAll(pool_.slacks(block));
  }
  // Both ends know a known node's error from now on.
  void settle(uint32_t number, uint8_t low) { nodes_.page(number).knowledge.settled.set(low); }
  // Both ends know a node from now on.
  void learn(uint32_t number, uint8_t low) { nodes_.page(number).knowledge.known.set(low); }
  void learn(uint32_t number, const SlotBits& nodes) {
    SlotBits& known = nodes_.page(number).knowledge.known;
    known = known | nodes;
  }
  void setKnowledge(uint32_t number, const PageKnowledge& knowledge) {
    nodes_.page(number).knowledge = knowledge;
    blocks_[number].radius = knowledge.radius;
  }
  // A node of the page was asked about.
  void noteDecision(uint32_t number, QuantisedError least) {
    QuantisedError& finest = nodes_.page(number).knowledge.finest;
    finest = std::min(finest, least);
  }
  // Drops the pages that have become empty, after a call of dropped(page) for each, ascending, and gives memory back
  // once a quarter more is held than is of use. Pages may get other numbers.
  template <class Dropped>
  void endStep(const Dropped& dropped) {
    nodes_.dropEmpty(dropped);
    compact();
  }

  size_t entryCount() const { return entries_; }
  size_t bytes() const { return nodes_.bytes() + blocks_.capacity() * sizeof(EntryBlock) + pool_.bytes(); }
  // CHECKs that every page's entries are those of its frontier nodes, in their order. O(entries).
  void validate() const;

 private:
  void compact();
  SlotBits consume(const MotionBound& motion, const EntryBlock& block);
  // Calls visit(number, first slot, block) for each page with entries, ascending.
  template <class Visit>
  void forEachBlock(const Visit& visit) const {
    constexpr size_t kAhead = 8;  // pages
    const auto order = nodes_.pages();
    for (size_t i = 0; i < order.size(); ++i) {
      if (i + kAhead < order.size()) pool_.prefetch(blocks_[order[i + kAhead].number]);
      const EntryBlock& block = blocks_[order[i].number];
      if (block.count > 0) visit(order[i].number, order[i].key * kPageSlots, block);
    }
  }

  Nodes nodes_;
  std::vector<EntryBlock> blocks_;  // by number of their page
  EntryPool pool_;
  size_t entries_ = 0;
};

}  // namespace foreland::proto
