// What it does to a frontier that nodes enter the section or leave it, node by node, for any topology: a node that is
// removed takes its children off the frontier, and its parents come to it unless they have other children; one that is
// added takes its parents off, and children with all their parents come to it. page_changes.h does the same for grids
// page by page, and must equal this.
//
// Nodes that come to the frontier become undecided in the scratch of the step, or pending if their page is not there.
// One owner: an adapter's step.
#pragma once

#include <algorithm>
#include <span>
#include <vector>

#include "proto/refine/adapt_scratch.h"
#include "proto/refine/frontier.h"

namespace foreland::proto {

template <class Topology>
class NodeChanges {
 public:
  NodeChanges(const Topology& topology, Frontier& frontier, AdaptScratch& scratch)
      : topology_(topology), frontier_(frontier), nodes_(frontier.nodes()), scratch_(scratch) {
    scratch_.leaving.assign(nodes_.pageCount(), {});
    scratch_.has_leaving.assign(nodes_.pageCount(), 0);
    scratch_.near_pages.resize(nodes_.pageCount() + 1);
  }
  // After pages were made.
  void grow() {
    scratch_.leaving.resize(nodes_.pageCount());
    scratch_.has_leaving.resize(nodes_.pageCount());
    scratch_.near_pages.resize(nodes_.pageCount() + 1);
  }

  // Nodes of a level, by page, ascending, that leave the section, or enter it.
  void remove(int level, std::span<const PagedBits> changed) {
    for (const PagedBits& page : changed) frontier_.removeFromSection(page.number, page.nodes);
    forEachNode(level, changed, [&](NodeId n) {
      for (NodeId child : topology_.children(n, level)) leave(topology_.slot(child, level + 1));
      for (NodeId parent : topology_.parents(n, level)) {
        const Slot above = topology_.slot(parent, level - 1);
        scratch_.markUndecided(nodes_.find(above), lowOf(above));
      }
    });
    endLeaving();
  }
  void add(int level, std::span<const PagedBits> changed) {
    for (const PagedBits& page : changed) frontier_.addToSection(page.number, page.nodes);
    forEachNode(level, changed, [&](NodeId n) {
      for (NodeId parent : topology_.parents(n, level)) leave(topology_.slot(parent, level - 1));
      for (NodeId child : topology_.children(n, level))
        if (topology_.hasOtherParent(child, n,
                                     [&](NodeId other) { return nodes_.isInSection(topology_.slot(other, level)); }))
          scratch_.considerAddable(nodes_, topology_.slot(child, level + 1), scratch_.pending);
    });
    endLeaving();
  }

  // Those of some nodes of a page, all in the section and undecided but not on the frontier, that stay off it, for they
  // have children in the section.
  template <class PageNodes>
  SlotBits innerOf(int level, const PageNodes& nodes, const SlotBits& some) const {
    SlotBits inner;
    some.forEach([&](uint8_t low) { inner.add(low, hasChildInSection(nodes.at(low), level)); });
    return inner;
  }

 private:
  template <class Visit>
  void forEachNode(int level, std::span<const PagedBits> pages, const Visit& visit) const {
    for (const PagedBits& page : pages) {
      const auto names = topology_.pageNodes(level, nodes_.page(page.number).first());
      page.nodes.forEach([&](uint8_t low) { visit(names.at(low)); });
    }
  }
  bool hasChildInSection(NodeId n, int level) const {
    bool any = false;  // without branches, for nothing foretells which children are there
    for (NodeId child : topology_.children(n, level)) any = any | nodes_.isInSection(topology_.slot(child, level + 1));
    return any;
  }
  // Takes a node off the frontier, if it is there, by the next call of endLeaving(), at the end of the level.
  void leave(Slot slot) {
    const uint32_t page = nodes_.find(slot);
    const bool leaves = nodes_.page(page).on_frontier.has(lowOf(slot));
    scratch_.leaving[page].add(lowOf(slot), leaves);
    scratch_.near_pages[left_pages_] = page;
    left_pages_ += (leaves & (scratch_.has_leaving[page] == 0)) ? 1 : 0;
    scratch_.has_leaving[page] |= static_cast<uint8_t>(leaves);
  }
  // Page by page: until then nothing reads the entries of these pages, which lie on a level that is done with.
  void endLeaving() {
    for (size_t i = 0; i < left_pages_; ++i) {
      const uint32_t page = scratch_.near_pages[i];
      SlotBits& leaving = scratch_.leaving[page];
      frontier_.leave(page, leaving);
      scratch_.undecided[page] = scratch_.undecided[page] - leaving;
      leaving = {};
      scratch_.has_leaving[page] = 0;
    }
    left_pages_ = 0;
  }

  const Topology& topology_;
  Frontier& frontier_;
  const Frontier::Nodes& nodes_;
  AdaptScratch& scratch_;
  size_t left_pages_ = 0;  // in scratch_.near_pages
};

}  // namespace foreland::proto
