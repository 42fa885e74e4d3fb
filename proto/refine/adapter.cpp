#include "proto/refine/adapter.h"

#include <algorithm>
#include <limits>

#include "proto/refine/terrain_batch.h"

namespace foreland::proto {

namespace {

// A step rounds a slack by at most 2^-24 of it. Slacks are kept 2^-9 short, and all entries are tested anew before 2^15
// steps can use that up.
constexpr double kSlackShare = 1 - 0x1p-9;
constexpr uint32_t kMostSteps = 1u << 15;
constexpr int kNonePasses = 256;
constexpr ErrorClass kAnyError{255}, kSomeError{1};

}  // namespace

// Endless if the views cannot be compared.
template <class Batch>
Metric::Toll Adapter<Batch>::tollTo(const View& view) const {
  if (last_ && last_->lens == view.lens && steps_ % kMostSteps != 0)
    return domain_->metric(*last_).tollTo(*last_, view);
  constexpr double kEndless = std::numeric_limits<double>::infinity();
  return {{kEndless, kEndless, kEndless}, {0, 0, 0}};
}

// One adaptation under way.
template <class Batch>
class Adapter<Batch>::Step {
 public:
  using Candidate = AdaptScratch::Candidate;

  Step(Adapter& adapter, const View& view, size_t max_nodes, NodeSource<Batch>& source, AdaptScratch& scratch,
       CutDelta& delta)
      : a_(adapter),
        frontier_(adapter.frontier_),
        domain_(*adapter.domain_),
        topology_(domain_.topology()),
        metric_(domain_.metric(view)),
        max_nodes_(max_nodes),
        source_(source),
        scratch_(scratch),
        delta_(delta) {
    const size_t levels = static_cast<size_t>(topology_.maxLevel()) + 2;
    const auto prepare = [levels](auto& lists) {
      lists.resize(std::max(lists.size(), levels));
      for (auto& list : lists) list.clear();
    };
    prepare(scratch_.going);
    prepare(scratch_.coming);
    prepare(scratch_.addable);
    scratch_.due.clear();
  }

  bool run(const Metric::Toll& toll) {
    frontier_.takeOff(toll, scratch_.due);
    testDue();
    for (int level = topology_.maxLevel(); level >= 1; --level)
      if (!remove(level)) return false;
    forgetLeft();
    if (!a_.has_seeds_) seed();
    for (int level = 1; level <= topology_.maxLevel(); ++level)
      if (!add(level)) return false;
    frontier_.endStep();
    return true;
  }

 private:
  static size_t at(int level) { return static_cast<size_t>(level); }
  bool isActive(NodeId n) const { return frontier_.isActive(topology_.slot(n)); }
  bool hasActiveChild(NodeId n) const {
    for (NodeId child : topology_.children(n))
      if (isActive(child)) return true;
    return false;
  }
  bool hasItsParents(NodeId n) const {
    for (NodeId parent : topology_.parents(n))
      if (!isActive(parent)) return false;
    return true;
  }

  void push(Slot slot, ErrorClass bound, RadiusClass radius) {
    const NodeId n = topology_.node(slot);
    const int level = topology_.level(n);
    batch_.push(n, slot, level, bound, domain_.radius(level, radius));
  }
  bool passed(size_t i) const { return batch_.guard[i] == static_cast<uint8_t>(Metric::Guard::kPasses); }
  uint16_t reach(size_t i) const { return Frontier::packReach(batch_.reach[i], batch_.guard[i]); }
  // Calls `visit(part)` for each part of the items that fits a batch.
  template <class Items, class Visit>
  static bool inBatches(Items& items, const Visit& visit) {
    for (size_t begin = 0; begin < items.size(); begin += Batch::kSize)
      if (!visit(std::span(items).subspan(begin, std::min(Batch::kSize, items.size() - begin)))) return false;
    return true;
  }
  void test() {
    batch_.testWithSlack(domain_, metric_, kSlackShare);
    a_.tests_ += batch_.count;
  }

  // An entry whose bound settles its test gets a new slack; the others are open.
  void testDue() {
    inBatches(scratch_.due, [this](std::span<const Frontier::Due> part) {
      batch_.count = 0;
      for (const Frontier::Due& due : part) push(due.slot, due.bound, due.radius);
      source_.load(batch_);
      test();
      for (size_t i = 0; i < part.size(); ++i) {
        const Frontier::Due& due = part[i];
        if (passed(i) == due.is_active) {
          frontier_.renew(due, batch_.slack[i], reach(i));
          continue;
        }
        auto& lists = due.is_active ? scratch_.going : scratch_.coming;
        lists[at(batch_.level[i])].push_back({{due.slot, due.bound, {}, due.is_active, false}});
      }
      return true;
    });
  }

  // Settles what each candidate is from now on (question.is_active), in ascending order, and gives each an entry.
  bool settleAll(int level, std::vector<Candidate>& candidates) {
    std::sort(candidates.begin(), candidates.end());
    return inBatches(candidates, [this, level](std::span<Candidate> part) {
      batch_.count = 0;
      for (const Candidate& c : part) push(c.question.slot, c.question.known, frontier_.radius(c.question.slot));
      source_.load(batch_);
      batch_.findLeast(domain_, metric_);
      if (!ask(level, part)) return false;
      test();
      for (size_t i = 0; i < part.size(); ++i)
        frontier_.list(batch_.slot[i], batch_.bound[i], batch_.slack[i], reach(i));
      return true;
    });
  }

  // Asks where what is known does not settle the test. The bounds of the entries are the batch's from now on.
  bool ask(int level, std::span<Candidate> part) {
    scratch_.questions.clear();
    scratch_.open.clear();
    for (size_t i = 0; i < part.size(); ++i) {
      Question& q = part[i].question;
      if (batch_.least[i] == kNonePasses) {
        if (q.is_active) batch_.bound[i] = kAnyError;
        q.is_active = false;
        continue;
      }
      q.least = {static_cast<uint8_t>(batch_.least[i])};
      // For addable nodes that have just come, and for leaves that turn round, it may be settled after all.
      if (q.is_active ? q.known >= q.least : q.known < q.least) continue;
      scratch_.questions.push_back(q);
      scratch_.open.push_back(static_cast<uint32_t>(i));
    }
    scratch_.answers.resize(scratch_.questions.size());
    if (!scratch_.questions.empty() && !source_.answer(level, scratch_.questions, scratch_.answers)) return false;
    for (size_t k = 0; k < scratch_.open.size(); ++k) {
      const uint32_t i = scratch_.open[k];
      Question& q = part[i].question;
      q.is_active = scratch_.answers[k] != 0;
      batch_.bound[i] = q.is_active ? q.least : ErrorClass{static_cast<uint8_t>(q.least.value - 1)};
    }
    return true;
  }

  // Leaves of a level that go take their children off the frontier and may bring their parents to it, which may go in
  // turn.
  bool remove(int level) {
    std::vector<Candidate>& going = scratch_.going[at(level)];
    if (going.empty()) return true;
    if (!settleAll(level, going)) return false;
    for (const Candidate& c : going) {
      if (c.question.is_active) continue;
      const Slot slot = c.question.slot;
      frontier_.setActive(slot, false);
      --a_.active_;
      delta_.removed.push_back(slot);
      const NodeId n = topology_.node(slot);
      for (NodeId child : topology_.children(n)) frontier_.unlist(topology_.slot(child));
      for (NodeId parent : topology_.parents(n)) {
        const Slot above = topology_.slot(parent);
        if (!isActive(parent) || frontier_.isListed(above) || hasActiveChild(parent)) continue;
        frontier_.list(above, kSomeError, 0, 0);  // holds its place
        scratch_.going[at(level - 1)].push_back({{above, kSomeError, {}, true, true}});
      }
    }
    return true;
  }

  // Addable nodes whose test is open, but which have left the frontier since.
  void forgetLeft() {
    for (auto& coming : scratch_.coming)
      std::erase_if(coming, [this](const Candidate& c) { return !frontier_.isListed(c.question.slot); });
  }

  // The whole frontier of a section of which only its own nodes are known.
  void seed() {
    a_.has_seeds_ = true;
    for (Slot slot = topology_.levelOffset(1); slot < topology_.levelOffset(2); ++slot)
      if (const NodeId n = topology_.node(slot); !topology_.isBase(n)) seed(1, slot);
    frontier_.forEach(Frontier::kActive, [this](Slot slot) {
      const NodeId n = topology_.node(slot);
      for (NodeId child : topology_.children(n))
        if (hasItsParents(child)) seed(topology_.level(n) + 1, topology_.slot(child));
    });
  }
  void seed(int level, Slot slot) {
    if (!frontier_.isActive(slot) && !frontier_.isListed(slot)) scratch_.addable[at(level)].push_back(slot);
  }

  // Candidates of a level: those whose test is open, and those that have just become addable.
  bool add(int level) {
    std::vector<Candidate>& coming = scratch_.coming[at(level)];
    greet(level, coming);
    if (coming.empty()) return true;
    if (!settleAll(level, coming)) return false;
    scratch_.slots.clear();
    scratch_.passed.clear();
    for (const Candidate& c : coming) {
      if (!c.question.is_active) continue;
      scratch_.slots.push_back(c.question.slot);
      scratch_.passed.push_back(c.question.least);
    }
    if (scratch_.slots.empty()) return true;
    if (a_.active_ + scratch_.slots.size() > max_nodes_) return false;
    if (!source_.onAdded(level, scratch_.slots, scratch_.passed)) return false;
    a_.active_ += scratch_.slots.size();
    delta_.added.insert(delta_.added.end(), scratch_.slots.begin(), scratch_.slots.end());
    for (Slot slot : scratch_.slots) frontier_.setActive(slot, true);
    for (Slot slot : scratch_.slots) {
      const NodeId n = topology_.node(slot);
      for (NodeId parent : topology_.parents(n)) frontier_.unlist(topology_.slot(parent));
      for (NodeId child : topology_.children(n))
        if (!isActive(child) && hasItsParents(child)) scratch_.addable[at(level) + 1].push_back(topology_.slot(child));
    }
    return true;
  }

  void greet(int level, std::vector<Candidate>& coming) {
    std::vector<Slot>& addable = scratch_.addable[at(level)];
    if (addable.empty()) return;
    std::sort(addable.begin(), addable.end());
    addable.erase(std::unique(addable.begin(), addable.end()), addable.end());
    for (Slot slot : addable)
      if (!frontier_.hasPage(slot)) frontier_.makePage(slot, source_.radius(slot));
    source_.onAddable(level, addable);
    for (Slot slot : addable) coming.push_back({{slot, kAnyError, {}, false, true}});
  }

  Adapter& a_;
  Frontier& frontier_;
  const Domain& domain_;
  const typename Domain::Topology& topology_;
  const Metric metric_;
  const size_t max_nodes_;
  NodeSource<Batch>& source_;
  AdaptScratch& scratch_;
  CutDelta& delta_;
  Batch batch_;
};

// The leaves are due at once; the rest of the frontier is found by the first step.
template <class Batch>
Adapter<Batch>::Adapter(const Domain& domain, std::span<const Slot> section, NodeSource<Batch>& source)
    : domain_(&domain), active_(section.size()) {
  const auto& topology = domain.topology();
  for (Slot slot : section) {
    if (!frontier_.hasPage(slot)) frontier_.makePage(slot, source.radius(slot));
    frontier_.setActive(slot, true);
  }
  for (Slot slot : section) {
    bool is_leaf = true;
    for (NodeId child : topology.children(topology.node(slot))) is_leaf = is_leaf && !contains(topology.slot(child));
    if (is_leaf) frontier_.list(slot, kSomeError, 0, 0);
  }
}

template <class Batch>
bool Adapter<Batch>::adapt(const View& view, size_t max_nodes, NodeSource<Batch>& source, AdaptScratch& scratch,
                           CutDelta& delta) {
  ++steps_;
  const Metric::Toll toll = tollTo(view);
  last_ = view;
  return Step(*this, view, max_nodes, source, scratch, delta).run(toll);
}

template <class Batch>
Section Adapter<Batch>::section() const {
  Section section;
  section.slots.reserve(active_);
  frontier_.forEach(Frontier::kActive, [&](Slot slot) { section.slots.push_back(slot); });
  std::sort(section.slots.begin(), section.slots.end());
  return section;
}

template <class Batch>
void Adapter<Batch>::validate() const {
  const auto& topology = domain_->topology();
  const auto active = [&](NodeId n) { return contains(topology.slot(n)); };
  size_t listed = 0;
  for (Slot slot = 0; slot < topology.slotCount(); ++slot) {
    const NodeId n = topology.node(slot);
    if (topology.isBase(n)) continue;
    const auto parents = topology.parents(n);
    const auto children = topology.children(n);
    const bool rooted = std::all_of(parents.begin(), parents.end(), active),
               leaf = std::none_of(children.begin(), children.end(), active);
    if (active(n)) CHECK_TRUE(rooted);
    CHECK_EQ(active(n) ? leaf : rooted, frontier_.isListed(slot));
    listed += frontier_.isListed(slot);
  }
  CHECK_EQ(listed, frontier_.entryCount());
}

template class Adapter<TerrainBatch>;

void settle(CutDelta& delta) {
  std::sort(delta.added.begin(), delta.added.end());
  std::sort(delta.removed.begin(), delta.removed.end());
}

}  // namespace foreland::proto
