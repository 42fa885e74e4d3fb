// Memory of an adaptation step that is reused from step to step (adapter.h). A worker's own.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "proto/refine/memory/paged_nodes.h"
#include "proto/refine/terrain_source.h"

namespace foreland::proto {

// Nodes of a page whose membership in the section is undecided in a step; and what becomes of them.
struct CandidatePage {
  uint32_t number = 0;
  SlotBits nodes;
  SlotBits entering;    // those that are new to the frontier, in this step
  SlotBits in_section;  // those that are in the section, once it is decided
};

// Nodes of a page.
struct PagedBits {
  uint32_t number = 0;
  SlotBits nodes;
};

// Some candidates of a level that are decided together, ascending, in columns beside those of the tester's batch.
struct CandidateColumns {
  static constexpr size_t kSize = 256;
  enum Flag : uint8_t {
    kIsNew = 1,      // to the frontier, in this step
    kIsKnown = 2,    // both ends know the node's height
    kIsSettled = 4,  // and its error
  };

  size_t count = 0;
  std::array<uint32_t, kSize> page;       // its number
  std::array<uint8_t, kSize> rank;        // among the page's entries
  std::array<uint8_t, kSize> flags;       // of Flag
  std::array<uint8_t, kSize> in_section;  // 1 if it is, before and then after the decision

  bool isNew(size_t i) const { return (flags[i] & kIsNew) != 0; }
  bool isKnown(size_t i) const { return (flags[i] & kIsKnown) != 0; }
  bool isSettled(size_t i) const { return (flags[i] & kIsSettled) != 0; }
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
  std::vector<CandidatePage> candidates;  // of a level, ascending
  CandidateColumns columns;
  // Candidates of a page that are in the columns, from `begin` on.
  struct Part {
    size_t candidates, begin;  // the former in `candidates`
  };
  std::vector<Part> parts;
  std::vector<PagedBits> changed;  // of the candidates: those that leave the section, or enter it
  std::vector<PagedBits> learnt;   // nodes that become known with the step's end
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
