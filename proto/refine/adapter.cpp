#include "proto/refine/adapter.h"

#include <algorithm>
#include <functional>

#include "proto/refine/slack.h"

namespace foreland::proto {

namespace {

bool arePageMates(Slot a, Slot b) { return a / kPageSlots == b / kPageSlots; }

}  // namespace

// Unbounded if the views cannot be compared.
template <class Tester>
MotionBound Adapter<Tester>::motionBoundTo(const View& view) const {
  if (last_ && last_->lens == view.lens && steps_ % kMostSteps != 0) return domain_->motionBound(*last_, view);
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
        tester_(*adapter.domain_, view, motion, source, adapter.memory_, scratch.decisions) {
    scratch_.undecided.assign(nodes_.pageCount(), {});
    scratch_.has_undecided.assign(nodes_.pageCount(), 0);
    scratch_.initial.clear();
    scratch_.pending.clear();
    scratch_.learnt.clear();
  }

  bool run() {
    if (!tester_.reviseBlocks(nodes_, [this](uint32_t page, uint8_t low) { markUndecided(page, low); })) return false;
    testStale();
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
  Slot begin(int level) const { return topology_.levelOffset(level); }
  bool isInSection(Slot slot) const { return nodes_.isInSection(slot); }
  bool hasChildInSection(NodeId n, int level) const {
    for (NodeId child : topology_.children(n))
      if (isInSection(topology_.slot(child, level + 1))) return true;
    return false;
  }
  bool hasParentsInSection(NodeId n, int level) const {
    for (NodeId parent : topology_.parents(n))
      if (!isInSection(topology_.slot(parent, level - 1))) return false;
    return true;
  }

  void markUndecided(uint32_t page, uint8_t low) {
    scratch_.undecided[page].set(low);
    scratch_.has_undecided[page] = 1;
  }

  // Stale entries that still hold get a new slack; the others are undecided.
  void testStale() {
    int level = 1;
    frontier_.consume(motion_, [&](uint32_t number, std::span<const uint32_t> indices) {
      const FrontierPage& page = nodes_.page(number);
      while (page.first() >= begin(level + 1)) ++level;
      const auto nodes = topology_.pageNodes(level, page.first());
      for (uint32_t index : indices) {
        const FrontierEntry entry = frontier_.entryAt(index);
        stale_[tester_.count()] = {number, index, page.in_section.has(entry.low())};
        tester_.push(nodes.at(entry.low()), level, page, entry);
        if (tester_.full()) finishStale();
      }
    });
    finishStale();
  }
  void finishStale() {
    tester_.test();
    a_.tests_ += tester_.count();
    for (size_t i = 0; i < tester_.count(); ++i)
      if (tester_.passes(i) == stale_[i].is_in_section)
        frontier_.renew(stale_[i].index, tester_.entry(i), tester_.slack(i));
      else
        markUndecided(stale_[i].page, lowOf(tester_.slot(i)));
    tester_.clear();
  }

  // Takes the undecided nodes of a level that are in the section, or those that are not, as candidates; ascending.
  enum class Which { kLeaves, kAddable };
  void collect(int level, Which which) {
    scratch_.candidates.clear();
    for (const Frontier::Nodes::PageName& name : nodes_.pagesOf(begin(level), begin(level + 1))) {
      const uint32_t number = name.number;
      if (!scratch_.has_undecided[number]) continue;
      const FrontierPage& page = nodes_.page(number);
      SlotBits& undecided = scratch_.undecided[number];
      const SlotBits taken = which == Which::kLeaves ? undecided & page.in_section : undecided - page.in_section;
      undecided = undecided - taken;
      if (which == Which::kAddable) frontier_.reserve(number, (taken - page.on_frontier).count());
      taken.forEach([&](uint8_t low) {
        scratch_.candidates.push_back({.slot = page.first() | low,
                                       .page = number,
                                       .is_in_section = which == Which::kLeaves,
                                       .is_new = !page.on_frontier.has(low),
                                       .is_known = page.knowledge.known.has(low),
                                       .is_settled = page.knowledge.settled.has(low)});
      });
    }
  }

  // Calls visit(candidate, node) for candidates of one level.
  template <class Visit>
  void forEach(int level, std::span<AdaptCandidate> candidates, const Visit& visit) {
    uint32_t page = Frontier::Nodes::kNone;
    auto nodes = topology_.pageNodes(level, begin(level));
    for (AdaptCandidate& c : candidates) {
      if (c.page != page) nodes = topology_.pageNodes(level, nodes_.page(page = c.page).first());
      visit(c, nodes.at(lowOf(c.slot)));
    }
  }

  // Decides for each candidate whether it is in the section from now on, and gives each an entry.
  bool resolve(int level) {
    std::vector<AdaptCandidate>& candidates = scratch_.candidates;
    for (size_t begin = 0; begin < candidates.size(); begin += Tester::kSize)
      if (!resolve(level, std::span(candidates).subspan(begin, std::min(Tester::kSize, candidates.size() - begin))))
        return false;
    return true;
  }
  bool resolve(int level, std::span<AdaptCandidate> part) {
    tester_.clear();
    forEach(level, part,
            [&](const AdaptCandidate& c, NodeId n) { tester_.push(n, level, nodes_.page(c.page), entryOf(c)); });
    if (!tester_.decide(level, part, frontier_)) return false;
    a_.tests_ += part.size();
    for (size_t i = 0; i < part.size(); ++i) frontier_.put(part[i].page, tester_.entry(i), tester_.slack(i));
    tester_.clear();
    return true;
  }
  FrontierEntry entryOf(const AdaptCandidate& c) const {
    if (!c.is_new) return frontier_.entry(nodes_.page(c.page), lowOf(c.slot));
    return c.is_in_section ? FrontierEntry::newLeaf(lowOf(c.slot)) : FrontierEntry::newAddable(lowOf(c.slot));
  }

  // Removes leaves of a level. Their children leave the frontier; parents without other children come to it, and may be
  // removed in turn.
  bool remove(int level) {
    collect(level, Which::kLeaves);
    dropInner(level);
    if (!resolve(level)) return false;
    std::vector<AdaptCandidate>& candidates = scratch_.candidates;
    std::erase_if(candidates, [](const AdaptCandidate& c) { return c.is_in_section; });
    a_.nodes_in_section_ -= candidates.size();
    forEach(level, candidates, [&](const AdaptCandidate& c, NodeId n) {
      frontier_.removeFromSection(c.page, lowOf(c.slot));
      for (NodeId child : topology_.children(n)) removeFromFrontier(topology_.slot(child, level + 1));
      for (NodeId parent : topology_.parents(n)) {
        const Slot above = topology_.slot(parent, level - 1);
        markUndecided(nodes_.find(above), lowOf(above));
      }
    });
    for (size_t i = candidates.size(); i-- > 0;) delta_.removed.push_back(candidates[i].slot);
    return true;
  }
  // Drops candidates that are no leaves: parents of removed nodes that have other children.
  void dropInner(int level) {
    size_t kept = 0;
    forEach(level, scratch_.candidates, [&](const AdaptCandidate& c, NodeId n) {
      if (!c.is_new || !hasChildInSection(n, level)) scratch_.candidates[kept++] = c;
    });
    scratch_.candidates.resize(kept);
  }
  void removeFromFrontier(Slot slot) {
    const uint32_t page = nodes_.find(slot);
    if (!nodes_.page(page).on_frontier.has(lowOf(slot))) return;
    frontier_.remove(page, lowOf(slot));
    scratch_.undecided[page].clear(lowOf(slot));
  }

  // Finds all nodes that can be added to a section of which only the leaves have entries.
  void findFrontier() {
    a_.is_complete_ = true;
    for (Slot slot = begin(1); slot < begin(2); ++slot)
      if (!topology_.isBase(topology_.node(slot))) considerAddable(slot, scratch_.initial);
    nodes_.forEachInSection([this](Slot slot) {
      const NodeId n = topology_.node(slot);
      const int below = topology_.level(n) + 1;
      for (NodeId child : topology_.children(n))
        if (hasParentsInSection(child, below)) considerAddable(topology_.slot(child, below), scratch_.initial);
    });
    std::sort(scratch_.initial.begin(), scratch_.initial.end(), std::greater<>());
  }
  // Takes a node whose parents are in the section as undecided, unless it is known; `pending` if its page does not
  // exist.
  void considerAddable(Slot slot, std::vector<Slot>& pending) {
    const uint32_t page = nodes_.find(slot);
    if (page == Frontier::Nodes::kNone)
      pending.push_back(slot);
    else if (!nodes_.page(page).in_section.has(lowOf(slot)) && !nodes_.page(page).on_frontier.has(lowOf(slot)))
      markUndecided(page, lowOf(slot));
  }

  // Adds nodes of a level: of those whose test is undecided and those that have just become addable.
  bool add(int level) {
    makePages(level);
    collect(level, Which::kAddable);
    std::vector<AdaptCandidate>& candidates = scratch_.candidates;
    tester_.tellAddable(level, candidates);
    if (!resolve(level)) return false;
    const auto count = static_cast<size_t>(
        std::count_if(candidates.begin(), candidates.end(), [](const AdaptCandidate& c) { return c.is_in_section; }));
    if (count == 0) return true;
    if (a_.nodes_in_section_ + count > max_nodes_) return false;
    std::erase_if(candidates, [](const AdaptCandidate& c) { return !c.is_in_section; });
    a_.nodes_in_section_ += count;
    for (const AdaptCandidate& c : candidates) {
      delta_.added.push_back(c.slot);
      if (!c.is_known) scratch_.learnt.push_back({c.page, lowOf(c.slot)});
      frontier_.addToSection(c.page, lowOf(c.slot));
    }
    forEach(level, candidates, [&](const AdaptCandidate&, NodeId n) {
      for (NodeId parent : topology_.parents(n)) removeFromFrontier(topology_.slot(parent, level - 1));
      for (NodeId child : topology_.children(n))
        if (topology_.hasOtherParent(child, n, [&](NodeId other) { return isInSection(topology_.slot(other, level)); }))
          considerAddable(topology_.slot(child, level + 1), scratch_.pending);
    });
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
    std::sort(pages.begin(), pages.end());
    pages.erase(std::unique(pages.begin(), pages.end(), arePageMates), pages.end());
    for (Slot slot : pages)
      if (nodes_.find(slot) == Frontier::Nodes::kNone)
        frontier_.makePage(slot, Tester::knowledgeOf(source_, a_.memory_, slot));
    scratch_.undecided.resize(nodes_.pageCount());
    scratch_.has_undecided.resize(nodes_.pageCount());
    for (Slot slot : pending) markUndecided(nodes_.find(slot), lowOf(slot));
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
  const typename Domain::Topology& topology_;
  const MotionBound motion_;
  const size_t max_nodes_;
  Source& source_;
  AdaptScratch& scratch_;
  CutDelta& delta_;
  Tester tester_;
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
    if (is_leaf) frontier_.put(nodes.find(slot), FrontierEntry::newLeaf(lowOf(slot)), 0);
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
  memory_.forEach([&](Slot first, const PageKnowledge& knowledge) { pages.push_back({first, knowledge}); });
  std::sort(pages.begin(), pages.end(), [](const KnownPage& a, const KnownPage& b) { return a.first < b.first; });
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
