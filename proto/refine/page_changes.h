// What node_changes.h does, for grids: page by page, on bits (page_neighbours.h). Changes of sections cluster, so most
// pages that are touched change by many nodes. One owner: an adapter's step.
#pragma once

#include <algorithm>
#include <span>
#include <vector>

#include "proto/refine/adapt_scratch.h"
#include "proto/refine/frontier.h"
#include "proto/refine/page_neighbours.h"

namespace foreland::proto {

class PageChanges {
 public:
  PageChanges(const GridTopology& grid, Frontier& frontier, AdaptScratch& scratch)
      : neighbours_(grid, frontier.nodes()), frontier_(frontier), nodes_(frontier.nodes()), scratch_(scratch) {}
  void grow() {}

  void remove(int level, std::span<const PagedBits> changed) {
    begin();
    for (const PagedBits& gone : changed) {
      frontier_.removeFromSection(gone.number, gone.nodes);
      noteNeighbours(level, nodes_.page(gone.number).first(), gone.nodes);
    }
    forEachOf(scratch_.new_pages, [&](Slot first, uint32_t number) {
      const FrontierPage& page = nodes_.page(number);
      const SlotBits addable = page.on_frontier - page.in_section;
      if (addable.any()) leave(number, addable - withParents(level + 1, first));
    });
    forEachOf(scratch_.near_pages, [&](Slot first, uint32_t number) {
      const FrontierPage& page = nodes_.page(number);
      const SlotBits inner = page.in_section - page.on_frontier;
      if (inner.any()) scratch_.markUndecided(number, inner - withChild(level - 1, first));
    });
  }

  void add(int level, std::span<const PagedBits> changed) {
    begin();
    for (const PagedBits& come : changed) {
      frontier_.addToSection(come.number, come.nodes);
      noteNeighbours(level, nodes_.page(come.number).first(), come.nodes);
    }
    forEachOf(scratch_.near_pages, [&](Slot first, uint32_t number) {
      const FrontierPage& page = nodes_.page(number);
      const SlotBits leaves = page.on_frontier & page.in_section;
      if (leaves.any()) leave(number, leaves & withChild(level - 1, first));
    });
    forEachOf(scratch_.new_pages, [&](Slot first, uint32_t number) {
      const FrontierPage& page = nodes_.page(number);
      const SlotBits addable = withParents(level + 1, first) - page.in_section - page.on_frontier;
      if (number != Frontier::Nodes::kNone)
        scratch_.markUndecided(number, addable);
      else
        addable.forEach([&](uint8_t low) { scratch_.pending.push_back(first | low); });
    });
  }

  // None: remove() marks only nodes without children.
  template <class PageNodes>
  SlotBits innerOf(int, const PageNodes&, const SlotBits&) const {
    return {};
  }

 private:
  SlotBits withParents(int level, Slot first) const {
    return neighbours_.withParents(level, neighbours_.placeOf(level, first));
  }
  SlotBits withChild(int level, Slot first) const {
    return neighbours_.withChild(level, neighbours_.placeOf(level, first));
  }

  void begin() {
    scratch_.near_pages.clear();
    scratch_.new_pages.clear();
  }
  // Notes the pages of the parents and of the children of some of a page's nodes.
  void noteNeighbours(int level, Slot first, const SlotBits& some) {
    const PageNeighbours::Place place = neighbours_.placeOf(level, first);
    neighbours_.parentPages(level, place, some, [&](Slot page) { scratch_.near_pages.push_back(page); });
    neighbours_.childPages(level, place, some, [&](Slot page) { scratch_.new_pages.push_back(page); });
  }
  // Once for each.
  template <class Visit>
  void forEachOf(std::vector<Slot>& pages, const Visit& visit) {
    std::sort(pages.begin(), pages.end());
    pages.erase(std::unique(pages.begin(), pages.end()), pages.end());
    for (Slot first : pages) visit(first, nodes_.find(first));
  }
  void leave(uint32_t number, const SlotBits& leaving) {
    if (!leaving.any()) return;
    frontier_.leave(number, leaving);
    scratch_.undecided[number] = scratch_.undecided[number] - leaving;
  }

  const PageNeighbours neighbours_;
  Frontier& frontier_;
  const Frontier::Nodes& nodes_;
  AdaptScratch& scratch_;
};

}  // namespace foreland::proto
