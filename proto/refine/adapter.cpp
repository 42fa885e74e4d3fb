#include "proto/refine/adapter.h"

#include <algorithm>
#include <functional>

#include "proto/refine/surface_batch.h"
#include "proto/refine/terrain_batch.h"

namespace foreland::proto {

namespace {

// A step rounds a slack by at most 2^-24 of it. Slacks are kept 2^-9 short, and all entries are tested anew before 2^15
// steps can use that up.
constexpr double kSlackShare = 1 - 0x1p-9;
constexpr uint32_t kMostSteps = 1u << 15;
constexpr int kNonePasses = 256;
constexpr QuantisedError kAnyError{255}, kSomeError{1}, kNoError{0};

uint8_t lowOf(Slot slot) { return static_cast<uint8_t>(slot); }
bool arePageMates(Slot a, Slot b) { return a / kPageSlots == b / kPageSlots; }

}  // namespace

// Endless if the views cannot be compared.
template <class Batch>
MotionBound Adapter<Batch>::motionBoundTo(const View& view) const {
  if (last_ && last_->lens == view.lens && steps_ % kMostSteps != 0)
    return domain_->metric(*last_).motionBoundTo(*last_, view);
  return MotionBound::unbounded();
}

// One adaptation under way.
template <class Batch>
class Adapter<Batch>::Step {
 public:
  using Candidate = AdaptScratch::Candidate;

  Step(Adapter& adapter, const View& view, const MotionBound& motion, size_t max_nodes, NodeSource<Batch>& source,
       AdaptScratch& scratch, CutDelta& delta)
      : a_(adapter),
        frontier_(adapter.frontier_),
        domain_(*adapter.domain_),
        topology_(domain_.topology()),
        metric_(domain_.metric(view)),
        motion_(motion),
        max_nodes_(max_nodes),
        source_(source),
        scratch_(scratch),
        delta_(delta) {
    scratch_.undecided.assign(frontier_.pageCount(), {});
    scratch_.has_undecided.assign(frontier_.pageCount(), 0);
    scratch_.seeds.clear();
    scratch_.pending.clear();
  }

  bool run() {
    testStale();
    const size_t removed = delta_.removed.size();
    for (int level = topology_.maxLevel(); level >= 1; --level)
      if (!remove(level)) return false;
    std::reverse(delta_.removed.begin() + static_cast<std::ptrdiff_t>(removed), delta_.removed.end());
    if (!a_.has_seeds_) seed();
    for (int level = 1; level <= topology_.maxLevel(); ++level)
      if (!add(level)) return false;
    frontier_.endStep();
    return true;
  }

 private:
  Slot begin(int level) const { return topology_.levelOffset(level); }
  bool isInSection(Slot slot) const { return frontier_.isInSection(slot); }
  bool hasActiveChild(NodeId n, int level) const {
    for (NodeId child : topology_.children(n))
      if (isInSection(topology_.slot(child, level + 1))) return true;
    return false;
  }
  bool hasItsParents(NodeId n, int level) const {
    for (NodeId parent : topology_.parents(n))
      if (!isInSection(topology_.slot(parent, level - 1))) return false;
    return true;
  }

  void undecided(uint32_t page, uint8_t low) {
    scratch_.undecided[page].set(low);
    scratch_.has_undecided[page] = 1;
  }

  void test() {
    batch_.testWithSlack(metric_, motion_, kSlackShare);
    a_.tests_ += batch_.count;
  }

  // An entry whose bound settles its test gets a new slack; the others are open.
  void testStale() {
    int level = 1;
    batch_.count = 0;
    frontier_.consume(motion_, [&](uint32_t number, std::span<const uint32_t> places) {
      const Frontier::Page& page = frontier_.page(number);
      while (page.first() >= begin(level + 1)) ++level;
      const auto nodes = topology_.pageNodes(level, page.first());
      const float radius = domain_.radius(level, page.radius);
      for (uint32_t place : places) {
        const Entry& entry = frontier_.entryAt(place);
        stale_[batch_.count] = {number, place, page.in_section.has(entry.low())};
        batch_.push(nodes.at(entry.low()), page.first() | entry.low(), level, entry.bound(), radius);
        if (batch_.full()) finishStale();
      }
    });
    finishStale();
  }
  void finishStale() {
    source_.load(batch_);
    batch_.locate(domain_, metric_);
    test();
    for (size_t i = 0; i < batch_.count; ++i)
      if ((batch_.passes[i] != 0) == stale_[i].is_in_section)
        frontier_.renew(stale_[i].place, batch_.slack[i], batch_.constraint[i]);
      else
        undecided(stale_[i].page, lowOf(batch_.slot[i]));
    batch_.count = 0;
  }

  // Takes a level's open nodes that are active, or the others, ascending.
  enum class Which { kLeaves, kAddable };
  void collect(int level, Which which) {
    scratch_.candidates.clear();
    for (const Frontier::PageName& name : frontier_.pagesOf(begin(level), begin(level + 1))) {
      const uint32_t number = name.number;
      if (!scratch_.has_undecided[number]) continue;
      const Frontier::Page& page = frontier_.page(number);
      SlotBits& undecided = scratch_.undecided[number];
      const SlotBits taken = which == Which::kLeaves ? undecided & page.in_section : undecided - page.in_section;
      undecided = undecided - taken;
      if (which == Which::kAddable) frontier_.reserve(number, (taken - page.on_frontier).count());
      taken.forEach([&](uint8_t low) {
        const bool is_new = !page.on_frontier.has(low);
        const QuantisedError known = !is_new                   ? frontier_.bound(page, low)
                                     : which == Which::kLeaves ? kSomeError
                                                               : kAnyError;
        scratch_.candidates.push_back({{page.first() | low, known, {}, which == Which::kLeaves, is_new}, number});
      });
    }
  }

  // Calls visit(candidate, node) for the candidates from `begin` to `end`, which are of one level.
  template <class Visit>
  void forEach(int level, std::span<Candidate> candidates, const Visit& visit) {
    uint32_t page = Frontier::kNone;
    auto nodes = topology_.pageNodes(level, begin(level));
    for (Candidate& c : candidates) {
      if (c.page != page) nodes = topology_.pageNodes(level, frontier_.page(page = c.page).first());
      visit(c, nodes.at(lowOf(c.predicate.slot)));
    }
  }

  // Settles what each candidate is from now on (question.is_in_section) and gives each an entry.
  bool resolve(int level) {
    std::vector<Candidate>& candidates = scratch_.candidates;
    for (size_t begin = 0; begin < candidates.size(); begin += Batch::kSize)
      if (!resolve(level, std::span(candidates).subspan(begin, std::min(Batch::kSize, candidates.size() - begin))))
        return false;
    return true;
  }
  bool resolve(int level, std::span<Candidate> part) {
    batch_.count = 0;
    forEach(level, part, [&](const Candidate& c, NodeId n) {
      batch_.push(n, c.predicate.slot, level, c.predicate.known, domain_.radius(level, frontier_.page(c.page).radius));
    });
    source_.load(batch_);
    batch_.locate(domain_, metric_);
    batch_.findLeast(metric_);
    if (!ask(level, part)) return false;
    test();
    for (size_t i = 0; i < part.size(); ++i)
      frontier_.list(part[i].page, lowOf(batch_.slot[i]), batch_.bound[i], batch_.slack[i], batch_.constraint[i]);
    return true;
  }

  // Asks where what is known does not settle the test. The bounds of the entries are the batch's from now on.
  bool ask(int level, std::span<Candidate> part) {
    scratch_.predicates.clear();
    scratch_.asked.clear();
    for (size_t i = 0; i < part.size(); ++i) {
      Predicate& q = part[i].predicate;
      if (batch_.least[i] == kNonePasses) {
        if (q.is_in_section) batch_.bound[i] = kAnyError;
        q.is_in_section = false;
        continue;
      }
      q.least = {static_cast<uint8_t>(batch_.least[i])};
      if (q.least == kNoError) {
        batch_.bound[i] = kNoError;
        q.is_in_section = true;
        continue;
      }
      // For addable nodes that have just come, and for leaves that turn round, it may be settled after all.
      if (q.is_in_section ? q.known >= q.least : q.known < q.least) continue;
      scratch_.predicates.push_back(q);
      scratch_.asked.push_back(static_cast<uint32_t>(i));
    }
    scratch_.decisions.resize(scratch_.predicates.size());
    if (!scratch_.predicates.empty() && !source_.decide(level, scratch_.predicates, scratch_.decisions)) return false;
    for (size_t k = 0; k < scratch_.asked.size(); ++k) {
      const uint32_t i = scratch_.asked[k];
      Predicate& q = part[i].predicate;
      q.is_in_section = scratch_.decisions[k] != 0;
      batch_.bound[i] = q.is_in_section ? q.least : QuantisedError{static_cast<uint8_t>(q.least.value - 1)};
    }
    return true;
  }

  // Leaves of a level that go take their children off the frontier and may bring their parents to it, which may go in
  // turn.
  bool remove(int level) {
    collect(level, Which::kLeaves);
    dropInner(level);
    if (!resolve(level)) return false;
    std::vector<Candidate>& candidates = scratch_.candidates;
    std::erase_if(candidates, [](const Candidate& c) { return c.predicate.is_in_section; });
    a_.nodes_in_section_ -= candidates.size();
    forEach(level, candidates, [&](const Candidate& c, NodeId n) {
      frontier_.setInSection(c.page, lowOf(c.predicate.slot), false);
      for (NodeId child : topology_.children(n)) unlist(topology_.slot(child, level + 1));
      for (NodeId parent : topology_.parents(n)) {
        const Slot above = topology_.slot(parent, level - 1);
        undecided(frontier_.find(above), lowOf(above));
      }
    });
    for (size_t i = candidates.size(); i-- > 0;) delta_.removed.push_back(candidates[i].predicate.slot);
    return true;
  }
  // Parents of what has gone that have other children.
  void dropInner(int level) {
    size_t kept = 0;
    forEach(level, scratch_.candidates, [&](const Candidate& c, NodeId n) {
      if (!c.predicate.is_new || !hasActiveChild(n, level)) scratch_.candidates[kept++] = c;
    });
    scratch_.candidates.resize(kept);
  }
  void unlist(Slot slot) {
    const uint32_t page = frontier_.find(slot);
    if (page == Frontier::kNone || !frontier_.page(page).on_frontier.has(lowOf(slot))) return;
    frontier_.unlist(page, lowOf(slot));
    scratch_.undecided[page].clear(lowOf(slot));
  }

  // The whole frontier of a section of which only its own nodes are known.
  void seed() {
    a_.has_seeds_ = true;
    for (Slot slot = begin(1); slot < begin(2); ++slot)
      if (!topology_.isBase(topology_.node(slot))) considerAddable(slot, scratch_.seeds);
    frontier_.forEachInSection([this](Slot slot) {
      const NodeId n = topology_.node(slot);
      const int below = topology_.level(n) + 1;
      for (NodeId child : topology_.children(n))
        if (hasItsParents(child, below)) considerAddable(topology_.slot(child, below), scratch_.seeds);
    });
    std::sort(scratch_.seeds.begin(), scratch_.seeds.end(), std::greater<>());
  }
  // A node that can be added.
  void considerAddable(Slot slot, std::vector<Slot>& pending) {
    const uint32_t page = frontier_.find(slot);
    if (page == Frontier::kNone)
      pending.push_back(slot);
    else if (!frontier_.page(page).in_section.has(lowOf(slot)) && !frontier_.page(page).on_frontier.has(lowOf(slot)))
      undecided(page, lowOf(slot));
  }

  // Candidates of a level: those whose test is open, and those that have just become addable.
  bool add(int level) {
    makePages(level);
    collect(level, Which::kAddable);
    std::vector<Candidate>& candidates = scratch_.candidates;
    scratch_.slots.clear();
    for (const Candidate& c : candidates)
      if (c.predicate.is_new) scratch_.slots.push_back(c.predicate.slot);
    if (!scratch_.slots.empty()) source_.onAddable(level, scratch_.slots);
    if (!resolve(level)) return false;
    std::erase_if(candidates, [](const Candidate& c) { return !c.predicate.is_in_section; });
    if (candidates.empty()) return true;
    if (a_.nodes_in_section_ + candidates.size() > max_nodes_) return false;
    scratch_.slots.clear();
    scratch_.passed.clear();
    for (const Candidate& c : candidates) {
      scratch_.slots.push_back(c.predicate.slot);
      scratch_.passed.push_back(c.predicate.least);
    }
    if (!source_.onAdded(level, scratch_.slots, scratch_.passed)) return false;
    a_.nodes_in_section_ += candidates.size();
    delta_.added.insert(delta_.added.end(), scratch_.slots.begin(), scratch_.slots.end());
    for (const Candidate& c : candidates) frontier_.setInSection(c.page, lowOf(c.predicate.slot), true);
    forEach(level, candidates, [&](const Candidate&, NodeId n) {
      for (NodeId parent : topology_.parents(n)) unlist(topology_.slot(parent, level - 1));
      for (NodeId child : topology_.children(n))
        if (topology_.hasOtherParent(child, n, [&](NodeId other) { return isInSection(topology_.slot(other, level)); }))
          considerAddable(topology_.slot(child, level + 1), scratch_.pending);
    });
    return true;
  }

  void makePages(int level) {
    std::vector<Slot>&seeds = scratch_.seeds, &pending = scratch_.pending;
    for (; !seeds.empty() && seeds.back() < begin(level + 1); seeds.pop_back()) pending.push_back(seeds.back());
    if (pending.empty()) return;
    std::vector<Slot>& pages = scratch_.pages;
    pages.clear();
    for (Slot slot : pending)
      if (pages.empty() || !arePageMates(pages.back(), slot))
        pages.push_back(slot);
      else
        pages.back() = std::min(pages.back(), slot);
    std::sort(pages.begin(), pages.end());
    pages.erase(std::unique(pages.begin(), pages.end(), arePageMates), pages.end());
    for (Slot slot : pages)
      if (frontier_.find(slot) == Frontier::kNone) frontier_.makePage(slot, source_.radius(slot));
    scratch_.undecided.resize(frontier_.pageCount());
    scratch_.has_undecided.resize(frontier_.pageCount());
    for (Slot slot : pending) undecided(frontier_.find(slot), lowOf(slot));
    frontier_.orderPages();
    pending.clear();
  }

  struct Stale {
    uint32_t page, place;
    bool is_in_section;
  };

  Adapter& a_;
  Frontier& frontier_;
  const Domain& domain_;
  const typename Domain::Topology& topology_;
  const typename Domain::Metric metric_;
  const MotionBound motion_;
  const size_t max_nodes_;
  NodeSource<Batch>& source_;
  AdaptScratch& scratch_;
  CutDelta& delta_;
  Batch batch_;
  std::array<Stale, Batch::kSize> stale_;
};

// The leaves are due at once; the rest of the frontier is found by the first step.
template <class Batch>
Adapter<Batch>::Adapter(const Domain& domain, std::span<const Slot> section, NodeSource<Batch>& source)
    : domain_(&domain), nodes_in_section_(section.size()) {
  const auto& topology = domain.topology();
  for (Slot slot : section) {
    if (frontier_.find(slot) == Frontier::kNone) frontier_.makePage(slot, source.radius(slot));
    frontier_.setInSection(frontier_.find(slot), lowOf(slot), true);
  }
  frontier_.orderPages();
  for (Slot slot : section) {
    bool is_leaf = true;
    for (NodeId child : topology.children(topology.node(slot))) is_leaf = is_leaf && !contains(topology.slot(child));
    if (is_leaf) frontier_.list(frontier_.find(slot), lowOf(slot), kSomeError, 0, 0);
  }
}

template <class Batch>
bool Adapter<Batch>::adapt(const View& view, size_t max_nodes, NodeSource<Batch>& source, AdaptScratch& scratch,
                           CutDelta& delta) {
  ++steps_;
  const MotionBound motion = motionBoundTo(view);
  last_ = view;
  return Step(*this, view, motion, max_nodes, source, scratch, delta).run();
}

template <class Batch>
Section Adapter<Batch>::section() const {
  Section section;
  section.slots.reserve(nodes_in_section_);
  frontier_.forEachInSection([&](Slot slot) { section.slots.push_back(slot); });
  return section;
}

template <class Batch>
void Adapter<Batch>::validate() const {
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
    CHECK_EQ(in_section(n) ? leaf : rooted, frontier_.isOnFrontier(slot));
    on_frontier += frontier_.isOnFrontier(slot);
  }
  CHECK_EQ(on_frontier, frontier_.entryCount());
}

template class Adapter<TerrainBatch>;
template class Adapter<SurfaceBatch>;

}  // namespace foreland::proto
