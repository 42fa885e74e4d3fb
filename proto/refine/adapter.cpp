#include "proto/refine/adapter.h"

#include <algorithm>
#include <bit>
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
    for (const PagedBits& page : scratch_.learnt) frontier_.learn(page.number, page.nodes);
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
    frontier_.forEachSwept([&](uint32_t number, Slot first, const EntryBlock& block, const uint32_t* bits,
                               const uint8_t* heights) {
      while (first >= begin(level + 1)) ++level;
      const Sweep::Found found = sweep.test(level, first, block, bits, heights);
      a_.swept_ += block.count;
      found.changed.forEach([&](uint8_t rank) { scratch_.markUndecided(number, static_cast<uint8_t>(bits[rank])); });
      if (found.unsure.any()) pushStale(number, level, found.unsure);
    });
    finishStale();
  }
  // By those whose slack is used up. Those that still hold get a new one.
  void testStale() {
    int level = 1;
    frontier_.consume(motion_, [&](uint32_t number, const SlotBits& ranks) {
      while (nodes_.page(number).first() >= begin(level + 1)) ++level;
      pushStale(number, level, ranks);
    });
    finishStale();
  }
  void pushStale(uint32_t number, int level, const SlotBits& ranks) {
    const FrontierPage& page = nodes_.page(number);
    const auto nodes = topology_.pageNodes(level, page.first());
    const float radius = tester_.radius(level, page);
    ranks.forEach([&](uint8_t rank) {
      const FrontierEntry entry{frontier_.entryBits(number)[rank]};
      stale_[tester_.count()] = {number, rank, page.in_section.has(entry.low())};
      tester_.push(nodes.at(entry.low()), page.first() | entry.low(), level, entry.bound(), radius);
      if (tester_.full()) finishStale();
    });
  }
  void finishStale() {
    tester_.test();
    a_.tests_ += tester_.count();
    // Without branches, for every other one is undecided. An undecided entry is replaced or removed in this step.
    for (size_t i = 0; i < tester_.count(); ++i) {
      const bool is_undecided = tester_.passes(i) != stale_[i].is_in_section;
      frontier_.renew(stale_[i].page, stale_[i].rank, tester_.entry(i, stale_[i].is_in_section));
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
    for (const Frontier::Nodes::PageName& name : nodes_.pagesOf(begin(level), begin(level + 1))) {
      if (!scratch_.has_undecided[name.number]) continue;
      SlotBits& undecided = scratch_.undecided[name.number];
      const SlotBits& in_section = nodes_.page(name.number).in_section;
      const SlotBits taken = which == Which::kLeaves ? undecided & in_section : undecided - in_section;
      undecided = undecided - taken;
      if (taken.any()) collect(level, which, name.number, taken);
    }
  }
  void collect(int level, Which which, uint32_t number, SlotBits taken) {
    const FrontierPage& page = nodes_.page(number);
    SlotBits entering = taken - page.on_frontier;
    if (which == Which::kLeaves) {  // parents of removed nodes, some of which have other children
      const SlotBits inner = changes_.innerOf(level, topology_.pageNodes(level, page.first()), entering);
      entering = entering - inner;
      taken = taken - inner;
    }
    frontier_.enter(number, entering,
                    which == Which::kLeaves ? FrontierEntry::newLeaf(0) : FrontierEntry::newAddable(0));
    scratch_.candidates.push_back({.number = number, .nodes = taken, .entering = entering, .in_section = {}});
  }
  // Decides for each candidate whether it is in the section from now on, and renews its entry.
  bool resolve(int level, Which which) {
    was_in_section_ = which == Which::kLeaves ? 1 : 0;
    scratch_.columns.count = 0;
    scratch_.parts.clear();
    tester_.clear();
    for (size_t k = 0; k < scratch_.candidates.size(); ++k) {
      SlotBits left = scratch_.candidates[k].nodes;
      while (left.any()) {
        runWithBitInstructions([&]() FORELAND_WITH_BIT_INSTRUCTIONS { left = fill(level, k, left); });
        if (scratch_.columns.count == Tester::kSize && !decide(level)) return false;
      }
    }
    return scratch_.columns.count == 0 || decide(level);
  }
  // Puts nodes of a page of candidates into the columns, and returns those for which there is no room.
  FORELAND_WITH_BIT_INSTRUCTIONS SlotBits fill(int level, size_t k, const SlotBits& nodes) {
    const CandidatePage& some = scratch_.candidates[k];
    const FrontierPage& page = nodes_.page(some.number);
    const auto names = topology_.pageNodes(level, page.first());
    const float radius = tester_.radius(level, page);
    const uint32_t number = some.number, *const bits = frontier_.entryBits(number);
    const Slot first = page.first();
    CandidateColumns& c = scratch_.columns;
    size_t count = c.count;
    scratch_.parts.push_back({k, count});
    uint32_t before = 0;  // of the page's entries
    SlotBits left = nodes;
    for (uint32_t w = 0; w < 4; ++w) {
      const uint64_t entering = some.entering.words[w], known = page.knowledge.known.words[w],
                     settled = page.knowledge.settled.words[w], on_frontier = page.on_frontier.words[w];
      uint64_t word = left.words[w];
      for (; word != 0 && count < Tester::kSize; word &= word - 1, ++count) {
        const auto bit = static_cast<uint32_t>(std::countr_zero(word));
        const uint32_t low = w << 6 | bit,
                       rank = before + static_cast<uint32_t>(std::popcount(on_frontier & (~word & (word - 1))));
        c.page[count] = number;
        c.rank[count] = static_cast<uint8_t>(rank);
        c.flags[count] =
            static_cast<uint8_t>((entering >> bit & 1) | (known >> bit & 1) << 1 | (settled >> bit & 1) << 2);
        tester_.push(names.at(low), first | low, level, FrontierEntry{bits[rank]}.bound(), radius);
      }
      left.words[w] = word;
      before += static_cast<uint32_t>(std::popcount(on_frontier));
    }
    c.count = count;
    return left;
  }
  // Those in the columns.
  bool decide(int level) {
    CandidateColumns& c = scratch_.columns;
    std::fill_n(c.in_section.begin(), c.count, was_in_section_);
    if (!tester_.decide(level, c, frontier_)) return false;
    a_.tests_ += c.count;
    scratch_.parts.push_back({0, c.count});
    for (size_t p = 0; p + 1 < scratch_.parts.size(); ++p) {
      const size_t begin = scratch_.parts[p].begin, end = scratch_.parts[p + 1].begin;
      CandidatePage& page = scratch_.candidates[scratch_.parts[p].candidates];
      SlotBits in_section = page.in_section;
      for (size_t i = begin; i < end; ++i) in_section.add(lowOf(tester_.slot(i)), c.in_section[i] != 0);
      page.in_section = in_section;
      frontier_.renew(page.number, std::span(c.rank).subspan(begin, end - begin),
                      [&](size_t i) { return tester_.entry(begin + i, c.in_section[begin + i] != 0); });
    }
    scratch_.parts.clear();
    tester_.clear();
    c.count = 0;
    return true;
  }
  // Takes as changed what is in the section now, or what is not; their number.
  size_t keep(Which which) {
    size_t count = 0;
    scratch_.changed.clear();
    runWithBitInstructions([&]() FORELAND_WITH_BIT_INSTRUCTIONS {
      for (const CandidatePage& c : scratch_.candidates) {
        const SlotBits nodes = which == Which::kLeaves ? c.in_section : c.nodes - c.in_section;
        if (!nodes.any()) continue;
        scratch_.changed.push_back({c.number, nodes});
        count += nodes.count();
      }
    });
    return count;
  }

  // Removes leaves of a level. Their children leave the frontier; parents without other children come to it, and may be
  // removed in turn.
  bool remove(int level) {
    collect(level, Which::kLeaves);
    if (!resolve(level, Which::kLeaves)) return false;
    a_.nodes_in_section_ -= keep(Which::kAddable);
    changes_.remove(level, scratch_.changed);
    for (size_t k = scratch_.changed.size(); k-- > 0;) {
      const Slot first = nodes_.page(scratch_.changed[k].number).first();
      scratch_.changed[k].nodes.forEachDescending([&](uint8_t low) { delta_.removed.push_back(first | low); });
    }
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
    tester_.tellAddable(level, scratch_.candidates, nodes_);
    if (!resolve(level, Which::kAddable)) return false;
    const size_t count = keep(Which::kLeaves);
    if (a_.nodes_in_section_ + count > max_nodes_) return count == 0;
    a_.nodes_in_section_ += count;
    for (const PagedBits& come : scratch_.changed) {
      const FrontierPage& page = nodes_.page(come.number);
      come.nodes.forEach([&](uint8_t low) { delta_.added.push_back(page.first() | low); });
      const SlotBits learnt = come.nodes - page.knowledge.known;
      if (learnt.any()) scratch_.learnt.push_back({come.number, learnt});
    }
    changes_.add(level, scratch_.changed);
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
    uint32_t page, rank;
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
  uint8_t was_in_section_ = 0;              // of the candidates
  std::array<Stale, Tester::kSize> stale_;  // of the nodes in the tester
};

// Leaves get entries without slack, so the first step tests them all; it finds the rest of the frontier, too.
template <class Tester>
Adapter<Tester>::Adapter(const Domain& domain, std::span<const Slot> section, Source& source)
    : domain_(&domain), frontier_(Tester::entryKind(domain)), memory_(domain), nodes_in_section_(section.size()) {
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
    if (is_leaf) frontier_.put(nodes.find(slot), Tester::unknownLeaf(domain, lowOf(slot)));
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
  frontier_ = Frontier(Tester::entryKind(*domain_));
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
