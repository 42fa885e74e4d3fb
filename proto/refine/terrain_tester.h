// TerrainTester tests terrain for an adapter (adapter.h). A client knows of the terrain only what it was sent, so every
// frontier entry has a bound on its node's error: from below if the node is in the section, from above if it can be
// added. Where the bound leaves a test open, the tester puts a predicate to the source: is the error at least the least
// that passes? The decision becomes the entry's new bound. Once decisions leave only one value, the error is settled;
// both ends remember settled errors (node_memory.h), so tests of such nodes need no predicates. Decisions, in the order
// of the predicates, are all that a client must be sent to know which nodes are added and removed, but for hidden
// blocks.
//
// Each step has a tester of its own. A tester is too large to be copied.
#pragma once

#include <array>
#include <span>

#include "proto/refine/adapt_scratch.h"
#include "proto/refine/block_nodes.h"
#include "proto/refine/frontier.h"
#include "proto/refine/hidden/hidden_blocks.h"
#include "proto/refine/sweep.h"
#include "proto/refine/terrain_batch.h"
#include "proto/refine/terrain_source.h"

namespace foreland::proto {

class TerrainTester {
 public:
  using Domain = TerrainDomain;
  using Source = TerrainSource;
  static constexpr size_t kSize = TerrainBatch::kSize;
  // Memory lasts from step to step, beside the frontier.
  struct Memory {
    HiddenBlocks blocks;
    bool hides = false;  // Nodes of hidden blocks are left out of the section.
    NodeMemory pages;    // Pages here have no node in the section or on its frontier.
    explicit Memory(const Domain& domain) : blocks(domain.grid) {}
    size_t bytes() const { return blocks.bytes() + pages.bytes(); }
    std::optional<QuantisedRadius> radius(Slot slot) const { return pages.radius(slot); }
    SlotBits known(Slot slot) const {
      const std::optional<PageKnowledge> page = pages.find(slot);
      return page ? page->known : SlotBits{};
    }
    bool knowsAnyOf64(Slot first) const { return pages.knowsAnyOf64(first); }
    void restart(Remembered remembered) {
      blocks.clear();
      hides = false;
      if (remembered == Remembered::kNothing) pages.clear();
    }
    void keep(Slot first, const PageKnowledge& knowledge) { pages.keep(first, knowledge); }
    std::vector<KnownPage> knownPages() const { return pages.pages(); }
  };

  TerrainTester(const Domain& domain, const View& view, const MotionBound& motion, Source& source, Memory& memory,
                DecisionScratch& scratch)
      : domain_(domain),
        metric_(domain.metric(view)),
        motion_(motion),
        source_(source),
        memory_(memory),
        scratch_(scratch) {}

  // Has the source revise the blocks, and calls undecide(page number, low) for each frontier node whose test a revised
  // block may change. Must be called first in a step. The result is false if the source stopped.
  template <class Undecide>
  bool reviseBlocks(const Frontier::Nodes& nodes, const Undecide& undecide);
  // Ends the frontier's step, remembers the pages that the frontier drops, and forgets blocks without nodes. Must be
  // called last in a step.
  void endStep(Frontier& frontier, uint32_t steps);

  // The knowledge of a page that comes to the frontier with the slot `first`: what is remembered of the page, or else
  // its radius alone.
  static PageKnowledge knowledgeOf(Source& source, Memory& memory, Slot first) {
    if (const auto remembered = memory.pages.take(first)) return *remembered;
    PageKnowledge knowledge;
    knowledge.radius = source.radius(first);
    return knowledge;
  }

  // Planar frontiers are swept (sweep.h), others have slacks.
  static EntryKind entryKind(const Domain& domain) { return domain.isPlanar() ? EntryKind::kSwept : EntryKind::kSlack; }
  // The entry of a leaf of whose error and height nothing is known: the next step tests it.
  static FrontierEntry unknownLeaf(const Domain& domain, uint8_t low) {
    const FrontierEntry leaf = FrontierEntry::newLeaf(low);
    if (entryKind(domain) == EntryKind::kSlack) return leaf;
    return FrontierEntry::swept(low, leaf.bound(), FrontierEntry::Stands::kInSection, FrontierEntry::kUnknown);
  }

  size_t count() const { return batch_.count; }
  bool full() const { return batch_.full(); }
  void clear() { batch_.count = 0; }
  // The radius of a page's nodes, metres, which they are pushed with.
  float radius(int level, const FrontierPage& page) const { return domain_.radius(level, page.knowledge.radius); }
  void push(NodeId n, Slot slot, int level, QuantisedError bound, float radius_m) {
    batch_.push(n, slot, level, bound, radius_m);
  }

  // Tests the nodes that were pushed against the bounds of their entries.
  void test();
  // Decides for some candidates of a level, all of which were pushed, whether they are in the section from now on. A
  // level with more candidates than kSize takes several calls. The result is false if the source stopped.
  bool decide(int level, CandidateColumns& candidates, Frontier& frontier);
  bool isSwept() const { return entryKind(domain_) == EntryKind::kSwept; }
  const Metric& metric() const { return metric_; }
  // These functions return what test() or decide() found for the node that was pushed as number `i`. `in_section` says
  // where the node stands from now on.
  Slot slot(size_t i) const { return batch_.slot[i]; }
  bool passes(size_t i) const { return batch_.passes[i] != 0; }
  FrontierEntry entry(size_t i, bool in_section) const {
    using enum FrontierEntry::Stands;
    if (!isSwept())
      return FrontierEntry::of(lowOf(batch_.slot[i]), batch_.bound[i], batch_.constraint[i], batch_.slack[i]);
    const bool is_hidden = decides_ && is_hidden_[i] != 0;
    return FrontierEntry::swept(lowOf(batch_.slot[i]), batch_.bound[i],
                                is_hidden ? kHidden : (in_section ? kInSection : kOutside), batch_.height[i]);
  }

  // Tells the source which of a level's candidates are new to the frontier and not known.
  void tellAddable(int level, std::span<const CandidatePage> candidates, const Frontier::Nodes& nodes);

 private:
  void setBounds(const CandidateColumns& candidates, const Frontier::Nodes& nodes);
  bool resolve(size_t i, CandidateColumns& candidates, QuantisedError finest);
  void collectPredicates(int level, CandidateColumns& candidates, const Frontier::Nodes& nodes);
  // Of a page, which parents of its nodes are known.
  class KnownParents;
  bool askSource(int level, CandidateColumns& candidates, Frontier& frontier);
  bool tellAdded(int level, const CandidateColumns& candidates);
  void settle(const CandidateColumns& candidates, Frontier& frontier);
  NodeId node(size_t i) const {
    return NodeId::at(static_cast<uint32_t>(batch_.x[i]), static_cast<uint32_t>(batch_.y[i]));
  }
  void leaveOutHidden(CandidateColumns& candidates);

  const Domain& domain_;
  const Metric metric_;
  const MotionBound motion_;
  Source& source_;
  Memory& memory_;
  DecisionScratch& scratch_;
  TerrainBatch batch_;
  std::array<uint8_t, kSize> is_hidden_;
  bool decides_ = false;  // what was called last is decide(), which sets is_hidden_
};

template <class Undecide>
bool TerrainTester::reviseBlocks(const Frontier::Nodes& nodes, const Undecide& undecide) {
  std::vector<BlockId>& changed = scratch_.changed_blocks;
  changed.clear();
  const bool hid = memory_.hides;
  if (!source_.reviseBlocks(memory_.blocks, memory_.hides, changed)) return false;
  for (const BlockId& block : changed) {
    const bool is_hidden = memory_.blocks.state(block) != BlockState::kHidden;
    memory_.blocks.set(block, is_hidden);
    forEachNodeAbout(domain_.grid, nodes, block, undecide);
  }
  if (memory_.hides != hid) {
    memory_.blocks.clear();
    nodes.forEachOnFrontier([&](Slot slot) { undecide(nodes.find(slot), lowOf(slot)); });
  }
  return true;
}

}  // namespace foreland::proto
