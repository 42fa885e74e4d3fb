#include "proto/refine/adapter.h"

#include <algorithm>
#include <functional>
#include <type_traits>

#include "base/bit_instructions.h"
#include "base/sort.h"
#include "proto/refine/metric/slack.h"
#include "proto/refine/node_changes.h"
#include "proto/refine/page_changes.h"

namespace foreland::proto {

namespace {

bool arePageMates(Slot a, Slot b) { return a / kPageSlots == b / kPageSlots; }

}  // namespace

// Unbounded if the views cannot be compared.
template <class Tester>
MotionBound Adapter<Tester>::motionBoundTo(const View& view) const {
  if (last_ && last_->lens == view.lens && steps_ % kMaxSteps != 0) return domain_->motionBound(*last_, view);
  return MotionBound::unbounded();
}

// One adaptation in progress.
template <class Tester>
class Adapter<Tester>::Step {
 public:
  Step(Adapter& adapter, const View& view, const MotionBound& motion, size_t max_nodes, Source& source,
       AdaptScratch& scratch, CutDelta& delta)
      : a_(adapter),
        frontier_(adapter.frontier_),
        nodes_(adapter.frontier_.nodes()),
        topology_(adapter.domain_->topology()),
        motion_(motion),
        max_nodes_(max_nodes),
        source_(source),
        scratch_(scratch),
        delta_(delta),
        tester_(*adapter.domain_, view, motion, source, adapter.memory_, scratch.decisions),
        changes_(topology_, frontier_, scratch) {
    scratch_.undecided.assign(nodes_.pageCount(), {});
    scratch_.has_undecided.assign(nodes_.pageCount(), 0);
    scratch_.initial.clear();
    scratch_.pending.clear();
    scratch_.learnt.clear();
  }

  bool run() {
    if (!tester_.reviseBlocks(nodes_, [this](uint32_t page, uint8_t low) { scratch_.markUndecided(page, low); }))
      return false;
    findUndecided();
    const size_t removed = delta_.removed.size();
    for (int level = topology_.maxLevel(); level >= 1; --level)
      if (!remove(level)) return false;
    std::reverse(delta_.removed.begin() + static_cast<std::ptrdiff_t>(removed), delta_.removed.end());
    if (!a_.is_complete_) findFrontier();
    for (int level = 1; level <= topology_.maxLevel(); ++level)
      if (!add(level)) return false;
    for (const AdaptScratch::PagedSlot& slot : scratch_.learnt) frontier_.learn(slot.page, slot.low);
    tester_.endStep(frontier_, a_.steps_);
    return true;
  }

 private:
  // Of grids by pages, of other topologies by nodes.
  using Topology = typename Domain::Topology;
  using Changes = std::conditional_t<std::is_same_v<Topology, GridTopology>, PageChanges, NodeChanges<Topology>>;

  Slot begin(int level) const { return topology_.levelOffset(level); }
  bool isInSection(Slot slot) const { return nodes_.isInSection(slot); }
  bool hasParentsInSection(NodeId n, int level) const {
    for (NodeId parent : topology_.parents(n, level))
      if (!isInSection(topology_.slot(parent, level - 1))) return false;
    return true;
  }

  // After pages were made.
  void growScratch() {
    scratch_.undecided.resize(nodes_.pageCount());
    scratch_.has_undecided.resize(nodes_.pageCount());
    changes_.grow();
  }

  // Finds the entries that are undecided: those that their tests contradict.
  void findUndecided() {
    if constexpr (std::is_same_v<Tester, TerrainTester>)
      if (tester_.isSwept()) return sweep(tester_);
    testStale();
  }
  // By a test of all of them. The unsure ones are tested exactly, before any is a candidate. A template, so that it is
  // not compiled for testers that sweep nothing.
  template <class SweptTester>
  void sweep(const SweptTester& tester) {
    int level = 1;
    const Sweep sweep(*a_.domain_, tester.metric(),
                      motion_.isUnbounded() ? HiddenEntries::kTest : HiddenEntries::kLeave);
    frontier_.forEachPage(
        [&](uint32_t number, const FrontierPage& page, const float* heights, const FrontierEntry* entries) {
          while (page.first() >= begin(level + 1)) ++level;
          const Sweep::Found found = sweep.test(level, page, heights, entries);
          a_.swept_ += page.entries;
          found.changed.forEach([&](uint8_t rank) { scratch_.markUndecided(number, entries[rank].low()); });
          if (found.unsure.any()) pushStale(number, page, level, found.unsure);
        });
    finishStale();
  }
  // By those whose slack is used up. Those that still hold get a new one.
  void testStale() {
    int level = 1;
    frontier_.consume(motion_, [&](uint32_t number, const SlotBits& ranks) {
      const FrontierPage& page = nodes_.page(number);
      while (page.first() >= begin(level + 1)) ++level;
      pushStale(number, page, level, ranks);
    });
    finishStale();
  }
  void pushStale(uint32_t number, const FrontierPage& page, int level, const SlotBits& ranks) {
    const auto nodes = topology_.pageNodes(level, page.first());
    const uint32_t first = frontier_.firstEntry(number);
    ranks.forEach([&](uint8_t rank) {
      const FrontierEntry entry = frontier_.entryAt(first + rank);
      stale_[tester_.count()] = {number, first + rank, page.in_section.has(entry.low())};
      tester_.push(nodes.at(entry.low()), level, page, entry);
      if (tester_.full()) finishStale();
    });
  }
  void finishStale() {
    tester_.test();
    a_.tests_ += tester_.count();
    // Without branches, for every other one is undecided. An undecided entry is replaced or removed in this step.
    for (size_t i = 0; i < tester_.count(); ++i) {
      const bool is_undecided = tester_.passes(i) != stale_[i].is_in_section;
      frontier_.renew(stale_[i].index, tester_.entry(i, stale_[i].is_in_section), tester_.slack(i));
      scratch_.undecided[stale_[i].page].add(lowOf(tester_.slot(i)), is_undecided);
      scratch_.has_undecided[stale_[i].page] |= static_cast<uint8_t>(is_undecided);
    }
    tester_.clear();
  }

  // Takes the undecided nodes of a level that are in the section, or those that are not, as candidates, ascending, and
  // puts those on the frontier that have come to it.
  enum class Which { kLeaves, kAddable };
  void collect(int level, Which which) {
    scratch_.candidates.clear();
    runWithBitInstructions([&]() FORELAND_WITH_BIT_INSTRUCTIONS { collectAll(level, which); });
  }
  FORELAND_WITH_BIT_INSTRUCTIONS void collectAll(int level, Which which) {
    for (const Frontier::Nodes::PageName& name : nodes_.pagesOf(begin(level), begin(level + 1))) {
      if (!scratch_.has_undecided[name.number]) continue;
      SlotBits& undecided = scratch_.undecided[name.number];
      const SlotBits& in_section = nodes_.page(name.number).in_section;
      const SlotBits taken = which == Which::kLeaves ? undecided & in_section : undecided - in_section;
      undecided = undecided - taken;
      if (taken.any()) collect(level, which, name.number, taken);
    }
  }
  FORELAND_WITH_BIT_INSTRUCTIONS void collect(int level, Which which, uint32_t number, SlotBits taken) {
    const FrontierPage& page = nodes_.page(number);
    const auto nodes = topology_.pageNodes(level, page.first());
    SlotBits entering = taken - page.on_frontier;
    if (which == Which::kLeaves) {  // parents of removed nodes, some of which have other children
      const SlotBits inner = changes_.innerOf(level, nodes, entering);
      entering = entering - inner;
      taken = taken - inner;
    }
    frontier_.enter(number, entering,
                    which == Which::kLeaves ? FrontierEntry::newLeaf(0) : FrontierEntry::newAddable(0));
    taken.forEachRanked(page.on_frontier, [&](uint8_t low, uint32_t rank) {
      scratch_.candidates.push_back({.node = nodes.at(low),
                                     .slot = page.first() | low,
                                     .page = number,
                                     .entry = frontier_.firstEntry(number) + rank,
                                     .is_in_section = which == Which::kLeaves,
                                     .is_new = entering.has(low),
                                     .is_known = page.knowledge.known.has(low),
                                     .is_settled = page.knowledge.settled.has(low)});
    });
  }
  // Decides for each candidate whether it is in the section from now on, and renews its entry.
  bool resolve(int level) {
    std::vector<AdaptCandidate>& candidates = scratch_.candidates;
    for (size_t begin = 0; begin < candidates.size(); begin += Tester::kSize)
      if (!resolve(level, std::span(candidates).subspan(begin, std::min(Tester::kSize, candidates.size() - begin))))
        return false;
    return true;
  }
  bool resolve(int level, std::span<AdaptCandidate> part) {
    tester_.clear();
    for (const AdaptCandidate& c : part) tester_.push(c.node, level, nodes_.page(c.page), frontier_.entryAt(c.entry));
    if (!tester_.decide(level, part, frontier_)) return false;
    a_.tests_ += part.size();
    for (size_t i = 0; i < part.size(); ++i)
      frontier_.renew(part[i].entry, tester_.entry(i, part[i].is_in_section), tester_.slack(i));
    tester_.clear();
    return true;
  }
  // Keeps the candidates that are in the section now, or those that are not. Without branches, for nothing foretells
  // it.
  void keep(Which which) {
    std::vector<AdaptCandidate>& candidates = scratch_.candidates;
    size_t kept = 0;
    for (const AdaptCandidate& c : candidates) {
      candidates[kept] = c;
      kept += c.is_in_section == (which == Which::kLeaves) ? 1 : 0;
    }
    candidates.resize(kept);
  }

  // Removes leaves of a level. Their children leave the frontier; parents without other children come to it, and may be
  // removed in turn.
  bool remove(int level) {
    collect(level, Which::kLeaves);
    if (!resolve(level)) return false;
    keep(Which::kAddable);
    std::vector<AdaptCandidate>& candidates = scratch_.candidates;
    a_.nodes_in_section_ -= candidates.size();
    changes_.remove(level, candidates);
    for (size_t i = candidates.size(); i-- > 0;) delta_.removed.push_back(candidates[i].slot);
    return true;
  }
  // Finds all nodes that can be added to a section of which only the leaves have entries.
  void findFrontier() {
    a_.is_complete_ = true;
    for (Slot slot = begin(1); slot < begin(2); ++slot)
      if (!topology_.isBase(topology_.node(slot))) scratch_.considerAddable(nodes_, slot, scratch_.initial);
    nodes_.forEachInSection([this](Slot slot) {
      const NodeId n = topology_.node(slot);
      const int below = topology_.level(n) + 1;
      for (NodeId child : topology_.children(n))
        if (hasParentsInSection(child, below))
          scratch_.considerAddable(nodes_, topology_.slot(child, below), scratch_.initial);
    });
    foreland::sort(scratch_.initial.begin(), scratch_.initial.end(), std::greater<>());
  }
  // Adds nodes of a level: of those whose test is undecided and those that have just become addable.
  bool add(int level) {
    makePages(level);
    collect(level, Which::kAddable);
    std::vector<AdaptCandidate>& candidates = scratch_.candidates;
    tester_.tellAddable(level, candidates);
    if (!resolve(level)) return false;
    keep(Which::kLeaves);
    if (a_.nodes_in_section_ + candidates.size() > max_nodes_) return candidates.empty();
    a_.nodes_in_section_ += candidates.size();
    for (const AdaptCandidate& c : candidates) {
      delta_.added.push_back(c.slot);
      if (!c.is_known) scratch_.learnt.push_back({c.page, lowOf(c.slot)});
    }
    changes_.add(level, candidates);
    return true;
  }

  // Makes the pages of the undecided nodes of a level that have none.
  void makePages(int level) {
    std::vector<Slot>&initial = scratch_.initial, &pending = scratch_.pending;
    for (; !initial.empty() && initial.back() < begin(level + 1); initial.pop_back()) pending.push_back(initial.back());
    if (pending.empty()) return;
    std::vector<Slot>& pages = scratch_.new_pages;
    pages.clear();
    for (Slot slot : pending)
      if (pages.empty() || !arePageMates(pages.back(), slot))
        pages.push_back(slot);
      else
        pages.back() = std::min(pages.back(), slot);
    foreland::sort(pages.begin(), pages.end());
    pages.erase(std::unique(pages.begin(), pages.end(), arePageMates), pages.end());
    for (Slot slot : pages)
      if (nodes_.find(slot) == Frontier::Nodes::kNone)
        frontier_.makePage(slot, Tester::knowledgeOf(source_, a_.memory_, slot));
    growScratch();
    for (Slot slot : pending) scratch_.markUndecided(nodes_.find(slot), lowOf(slot));
    frontier_.orderPages();
    pending.clear();
  }

  struct Stale {
    uint32_t page, index;
    bool is_in_section;
  };

  Adapter& a_;
  Frontier& frontier_;
  const Frontier::Nodes& nodes_;
  const Topology& topology_;
  const MotionBound motion_;
  const size_t max_nodes_;
  Source& source_;
  AdaptScratch& scratch_;
  CutDelta& delta_;
  Tester tester_;
  Changes changes_;
  std::array<Stale, Tester::kSize> stale_;  // of the nodes in the tester
};

// Leaves get entries without slack, so the first step tests them all; it finds the rest of the frontier, too.
template <class Tester>
Adapter<Tester>::Adapter(const Domain& domain, std::span<const Slot> section, Source& source)
    : domain_(&domain), memory_(domain), nodes_in_section_(section.size()) {
  const auto& topology = domain.topology();
  const Frontier::Nodes& nodes = frontier_.nodes();
  for (Slot slot : section) {
    if (nodes.find(slot) == Frontier::Nodes::kNone)
      frontier_.makePage(slot, Tester::knowledgeOf(source, memory_, slot));
    frontier_.addToSection(nodes.find(slot), lowOf(slot));
    frontier_.learn(nodes.find(slot), lowOf(slot));
    frontier_.noteDecision(nodes.find(slot), {});
  }
  frontier_.orderPages();
  for (Slot slot : section) {
    bool is_leaf = true;
    for (NodeId child : topology.children(topology.node(slot))) is_leaf = is_leaf && !contains(topology.slot(child));
    if (is_leaf)
      frontier_.put(nodes.find(slot), Tester::unknownLeaf(domain, lowOf(slot)), Tester::unknownSlack(domain));
  }
}

template <class Tester>
void Adapter<Tester>::learn(std::span<const KnownPage> pages) {
  for (size_t i = pages.size(); i-- > 0;) {
    const uint32_t number = frontier_.nodes().find(pages[i].first);
    if (number == Frontier::Nodes::kNone)
      memory_.keep(pages[i].first, pages[i].knowledge);
    else
      frontier_.setKnowledge(number, pages[i].knowledge);
  }
}

template <class Tester>
void Adapter<Tester>::restart(Remembered remembered) {
  const std::vector<KnownPage> pages = livePages();
  frontier_ = Frontier();
  memory_.restart(remembered);
  if (remembered == Remembered::kPages)
    for (const KnownPage& page : pages) memory_.keep(page.first, page.knowledge);
  last_.reset();
  is_complete_ = false;
  nodes_in_section_ = 0;
  steps_ = 0;
}

template <class Tester>
std::vector<KnownPage> Adapter<Tester>::livePages() const {
  std::vector<KnownPage> pages;
  for (const Frontier::Nodes::PageName& name : frontier_.nodes().pages()) {
    const FrontierPage& page = frontier_.nodes().page(name.number);
    pages.push_back({page.first(), page.knowledge});
  }
  return pages;
}

template <class Tester>
std::vector<KnownPage> Adapter<Tester>::knownPages() const {
  std::vector<KnownPage> pages = livePages();
  const std::vector<KnownPage> remembered = memory_.knownPages();
  pages.insert(pages.end(), remembered.begin(), remembered.end());
  foreland::sort(pages.begin(), pages.end(), [](const KnownPage& a, const KnownPage& b) { return a.first < b.first; });
  return pages;
}

template <class Tester>
bool Adapter<Tester>::adapt(const View& view, size_t max_nodes, Source& source, AdaptScratch& scratch,
                            CutDelta& delta) {
  ++steps_;
  const MotionBound motion = motionBoundTo(view);
  last_ = view;
  return Step(*this, view, motion, max_nodes, source, scratch, delta).run();
}

template <class Tester>
Section Adapter<Tester>::section() const {
  Section section;
  section.slots.reserve(nodes_in_section_);
  frontier_.nodes().forEachInSection([&](Slot slot) { section.slots.push_back(slot); });
  return section;
}

template <class Tester>
void Adapter<Tester>::validate() const {
  frontier_.validate();
  const auto& topology = domain_->topology();
  const auto in_section = [&](NodeId n) { return contains(topology.slot(n)); };
  size_t on_frontier = 0;
  for (Slot slot = 0; slot < topology.slotCount(); ++slot) {
    const NodeId n = topology.node(slot);
    if (topology.isBase(n)) continue;
    const auto parents = topology.parents(n);
    const auto children = topology.children(n);
    const bool rooted = std::all_of(parents.begin(), parents.end(), in_section),
               leaf = std::none_of(children.begin(), children.end(), in_section);
    if (in_section(n)) CHECK_TRUE(rooted);
    CHECK_EQ(in_section(n) ? leaf : rooted, frontier_.nodes().isOnFrontier(slot));
    on_frontier += frontier_.nodes().isOnFrontier(slot);
  }
  CHECK_EQ(on_frontier, frontier_.entryCount());
}

template class Adapter<TerrainTester>;
template class Adapter<SurfaceTester>;

}  // namespace foreland::proto
