// A section and its frontier as an adapter keeps them (paged_nodes.h), with an entry for each frontier node: what is
// known of its error, and how much motion its last test survives, or the height of its sphere where all entries are
// tested in each step. A page's entries stand in the order of its slots, so
// an entry is found by counting bits.
//
// One owner. No allocation once grown to the section's size.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <utility>

#include "proto/refine/memory/entry_pool.h"
#include "proto/refine/memory/node_memory.h"
#include "proto/refine/memory/paged_nodes.h"
#include "proto/refine/metric/motion_bound.h"
#include "proto/section/bounds.h"

namespace foreland::proto {

struct FrontierPage : NodePage {
  uint16_t entries = 0;
  EntryPool::Block block;  // where its entries are
  PageKnowledge knowledge;
};

class Frontier {
 public:
  using Page = FrontierPage;
  using Nodes = PagedNodes<Page>;

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
  void put(uint32_t number, FrontierEntry entry, float slack);
  // Puts nodes of a page on the frontier, none of which is there, with entries as `blank` but for their slots, without
  // slack.
  void enter(uint32_t number, const SlotBits& nodes, FrontierEntry blank);
  // Takes nodes of a page off the frontier, all of which must be there.
  void leave(uint32_t number, const SlotBits& nodes);
  // The entry of a frontier node.
  FrontierEntry entry(const Page& page, uint8_t low) const {
    return pool_.entries(page.block)[page.on_frontier.countBefore(low)];
  }

  // Takes the motion of a step off every slack and calls visit(number, ranks) for each page with entries whose slack is
  // used up: the ranks of these among the page's entries.
  template <class Visit>
  void consume(const MotionBound& motion, const Visit& visit) {
    constexpr size_t kAhead = 8;  // pages
    const auto order = nodes_.pages();
    for (size_t i = 0; i < order.size(); ++i) {
      if (i + 2 * kAhead < order.size()) __builtin_prefetch(&nodes_.page(order[i + 2 * kAhead].number));
      if (i + kAhead < order.size()) pool_.prefetch(nodes_.page(order[i + kAhead].number).block);
      const uint32_t number = order[i].number;
      if (const SlotBits ranks = consume(motion, nodes_.page(number)); ranks.any()) visit(number, ranks);
    }
  }
  // Calls visit(number, page, slacks or heights, entries) for each page with entries, ascending.
  template <class Visit>
  void forEachPage(const Visit& visit) {
    constexpr size_t kAhead = 8;  // pages
    const auto order = nodes_.pages();
    for (size_t i = 0; i < order.size(); ++i) {
      if (i + 2 * kAhead < order.size()) __builtin_prefetch(&nodes_.page(order[i + 2 * kAhead].number));
      if (i + kAhead < order.size()) pool_.prefetch(nodes_.page(order[i + kAhead].number).block);
      const Page& page = nodes_.page(order[i].number);
      if (page.entries > 0)
        visit(order[i].number, page, std::as_const(pool_).slack(page.block), std::as_const(pool_).entries(page.block));
    }
  }
  // By their index in the pool; first that of a page's first entry.
  uint32_t firstEntry(uint32_t number) const { return nodes_.page(number).block.first; }
  FrontierEntry entryAt(uint32_t index) const { return pool_.entryAt(index); }
  // Replaces the entry of the same node, and its slack, or its height if the frontier is swept.
  void renew(uint32_t index, FrontierEntry entry, float slack) {
    pool_.slackAt(index) = slack;
    pool_.entryAt(index) = entry;
  }
  // Both ends know a known node's error from now on.
  void settle(uint32_t number, uint8_t low) { nodes_.page(number).knowledge.settled.set(low); }
  // Both ends know a node from now on.
  void learn(uint32_t number, uint8_t low) { nodes_.page(number).knowledge.known.set(low); }
  void setKnowledge(uint32_t number, const PageKnowledge& knowledge) { nodes_.page(number).knowledge = knowledge; }
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
  size_t bytes() const { return nodes_.bytes() + pool_.bytes(); }
  // CHECKs that every page's entries are those of its frontier nodes, in their order. O(entries).
  void validate() const;

 private:
  void compact();
  SlotBits consume(const MotionBound& motion, const Page& page);

  Nodes nodes_;
  EntryPool pool_;
  size_t entries_ = 0;
};

}  // namespace foreland::proto
