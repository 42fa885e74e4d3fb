// How an adapter (adapter.h) tests terrain, of which a client knows only what it was told. Both ends know the errors of
// nodes that were ever added, as long as they remember them (node_memory.h), so the tests of these need nothing. Of a
// node that is not known an entry has a bound on its error, from above. Where that leaves a test open, a predicate, "is
// the error at least the least that passes?", is put to the source. The decision becomes the entry's bound if it is no;
// if it is yes, the source tells the error. So the decisions and errors, in the order of the predicates, are all that a
// client must be told of which nodes are added and removed.
//
// A step's own; too large to be copied.
#pragma once

#include <array>
#include <span>

#include "proto/refine/adapt_scratch.h"
#include "proto/refine/block_nodes.h"
#include "proto/refine/frontier.h"
#include "proto/refine/hidden/hidden_blocks.h"
#include "proto/refine/terrain_batch.h"
#include "proto/refine/terrain_source.h"

namespace foreland::proto {

class TerrainTester {
 public:
  using Domain = TerrainDomain;
  using Source = TerrainSource;
  static constexpr size_t kSize = TerrainBatch::kSize;
  // What is remembered from step to step beside the frontier.
  struct Memory {
    HiddenBlocks blocks;
    bool hides = false;  // nodes of hidden blocks are left out
    NodeMemory pages;    // those without nodes in the section or on its frontier
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

  // First in a step: has the source revise the blocks, and calls undecide(page number, low) for each frontier node that
  // this may concern. False if the source stopped.
  template <class Undecide>
  bool reviseBlocks(const Frontier::Nodes& nodes, const Undecide& undecide);
  // Last in a step: ends that of the frontier, remembers the pages it drops, and forgets blocks without nodes.
  void endStep(Frontier& frontier, uint32_t steps);

  // What is known of the page of a slot that has come to the frontier.
  static PageKnowledge knowledgeOf(Source& source, Memory& memory, Slot first) {
    if (const auto remembered = memory.pages.take(first)) return *remembered;
    PageKnowledge knowledge;
    knowledge.radius = source.radius(first);
    return knowledge;
  }

  size_t count() const { return batch_.count; }
  bool full() const { return batch_.full(); }
  void clear() { batch_.count = 0; }
  void push(NodeId n, int level, const FrontierPage& page, FrontierEntry entry) {
    batch_.push(n, page.first() | entry.low(), level, entry.bound(), domain_.radius(level, page.knowledge.radius));
  }

  // Tests the nodes pushed by the bounds of their entries.
  void test();
  // Decides for the candidates of a level, all of which were pushed, whether they are in the section from now on.
  // As many parts as it takes. False if the source stopped.
  bool decide(int level, std::span<AdaptCandidate> candidates, Frontier& frontier);
  // What test() and decide() found of node `i`.
  Slot slot(size_t i) const { return batch_.slot[i]; }
  bool passes(size_t i) const { return batch_.passes[i] != 0; }
  FrontierEntry entry(size_t i) const {
    return FrontierEntry::of(lowOf(batch_.slot[i]), batch_.bound[i], batch_.constraint[i]);
  }
  float slack(size_t i) const { return batch_.slack[i]; }

  // Tells the source which of a level's candidates are new to the frontier.
  void tellAddable(int level, std::span<const AdaptCandidate> candidates);

 private:
  void setBounds(std::span<const AdaptCandidate> candidates, const Frontier::Nodes& nodes);
  bool resolve(size_t i, AdaptCandidate& candidate, QuantisedError finest);
  void collectPredicates(int level, std::span<AdaptCandidate> candidates, const Frontier::Nodes& nodes);
  Predicate predicateOf(size_t i, int level, const AdaptCandidate& c, const Frontier::Nodes& nodes) const;
  ClientKnowledge clientKnowledgeOf(size_t i, int level, const AdaptCandidate& c, QuantisedError least,
                                    const Frontier::Nodes& nodes) const;
  bool askSource(int level, std::span<AdaptCandidate> candidates, Frontier& frontier);
  bool tellAdded(int level, std::span<const AdaptCandidate> candidates);
  void settle(std::span<const AdaptCandidate> candidates, Frontier& frontier);
  NodeId node(size_t i) const {
    return NodeId::at(static_cast<uint32_t>(batch_.x[i]), static_cast<uint32_t>(batch_.y[i]));
  }
  void leaveOutHidden(std::span<AdaptCandidate> candidates);

  const Domain& domain_;
  const Metric metric_;
  const MotionBound motion_;
  Source& source_;
  Memory& memory_;
  DecisionScratch& scratch_;
  TerrainBatch batch_;
  std::array<uint8_t, kSize> is_hidden_;
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
