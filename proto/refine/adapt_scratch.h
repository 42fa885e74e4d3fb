// Memory of an adaptation step that is reused from step to step (adapter.h). A worker's own.
#pragma once

#include <cstdint>
#include <vector>

#include "proto/refine/memory/paged_nodes.h"
#include "proto/refine/terrain_source.h"

namespace foreland::proto {

// A node whose membership in the section is undecided in a step.
struct AdaptCandidate {
  NodeId node;
  Slot slot = 0;
  uint32_t page = 0;  // its number
  uint32_t rank = 0;  // among the page's entries
  bool is_in_section = false;
  bool is_new = false;      // to the frontier, in this step
  bool is_known = false;    // both ends know the node's height
  bool is_settled = false;  // and its error
};

// For terrain only: the predicates of some candidates (terrain_tester.h).
struct DecisionScratch {
  std::vector<Predicate> predicates, added;  // those that add nodes that were not known
  std::vector<uint32_t> asked;               // the batch index of each predicate
  std::vector<uint8_t> decisions;
  std::vector<Slot> slots;
  std::vector<BlockId> changed_blocks;
};

struct AdaptScratch {
  // By page: nodes whose test is undecided, or that may have come to the frontier; and whether there are any.
  std::vector<SlotBits> undecided;
  std::vector<uint8_t> has_undecided;
  // By page: nodes that leave the frontier, and whether there are any (node_changes.h).
  std::vector<SlotBits> leaving;
  std::vector<uint8_t> has_leaving;
  // Pages about nodes that have changed: by number those that nodes leave (node_changes.h), or by first slot those of
  // parents (page_changes.h).
  std::vector<uint32_t> near_pages;
  // Undecided nodes whose pages do not exist yet: of any level, descending; and of the level that is next.
  std::vector<Slot> initial, pending;
  // Of each such page the first undecided node; or the first slots of pages of children of nodes that have changed
  // (page_changes.h).
  std::vector<Slot> new_pages;
  std::vector<AdaptCandidate> candidates;
  // Nodes that become known with the step's end.
  struct PagedSlot {
    uint32_t page;  // its number
    uint8_t low;
  };
  std::vector<PagedSlot> learnt;
  DecisionScratch decisions;

  void markUndecided(uint32_t page, uint8_t low) {
    undecided[page].set(low);
    has_undecided[page] = 1;
  }
  void markUndecided(uint32_t page, const SlotBits& some) {
    undecided[page] = undecided[page] | some;
    has_undecided[page] |= some.any() ? 1 : 0;
  }
  // Takes a node whose parents are in the section as undecided, unless it is known; as one of `without_page` if its
  // page does not exist.
  template <class Nodes>
  void considerAddable(const Nodes& nodes, Slot slot, std::vector<Slot>& without_page) {
    const uint32_t page = nodes.find(slot);
    if (page == Nodes::kNone)
      without_page.push_back(slot);
    else if (!nodes.page(page).in_section.has(lowOf(slot)) && !nodes.page(page).on_frontier.has(lowOf(slot)))
      markUndecided(page, lowOf(slot));
  }
};

}  // namespace foreland::proto
