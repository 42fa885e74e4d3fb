// The protocol's law of questions (docs/PROTOCOL.md, section 10): what is predicates, in which order and in which
// groups, is a matter of the section, the bounds and the view, not of which nodes an adapter takes the trouble to test.
// The reference tests the whole frontier at every step.
#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <set>

#include "proto/refine/node_positions.h"
#include "tests/support/scene.h"
#include "tests/support/wanderer.h"

namespace foreland::proto {
namespace {

using server::Hierarchy;

// Something that is sent, or where a group of questions begins.
struct Event {
  enum Kind : uint8_t { kRadius, kGroup, kPredicate, kHeight };
  Kind kind;
  Slot slot = 0;
  int known = 0, least = 0;
  bool is_in_section = false, is_new = false;
  bool operator==(const Event&) const = default;
};
using Events = std::vector<Event>;

// The adapter's, as it asks.
class Listener final : public TerrainSource {
 public:
  explicit Listener(const Hierarchy& h) : plain_(h.nodes()) {}
  Events events;

  QuantisedRadius radius(Slot first) override {
    events.push_back({Event::kRadius, first});
    return plain_.radius(first);
  }
  void load(TerrainBatch& batch) override { plain_.load(batch); }
  bool decide(int level, std::span<const Predicate> predicates, std::span<uint8_t> decisions) override {
    events.push_back({Event::kGroup});
    for (const Predicate& q : predicates)
      events.push_back({Event::kPredicate, q.slot, q.known.value, q.least.value, q.is_in_section, q.is_new});
    return plain_.decide(level, predicates, decisions);
  }
  bool onAdded(int, std::span<const Slot> slots, std::span<const QuantisedError> passed) override {
    for (size_t i = 0; i < slots.size(); ++i) events.push_back({Event::kHeight, slots[i], 0, passed[i].value});
    return true;
  }

 private:
  InMemoryNodes plain_;
};

// Section 10, word for word.
class Reference {
 public:
  // Begins with a section that is held, perhaps the empty one.
  explicit Reference(const Hierarchy& h, const Section& held = {})
      : h_(h), grid_(h.grid()), section_(held.slots.begin(), held.slots.end()) {
    for (Slot slot : section_) {
      pages_.insert(slot / kPageSlots);
      if (isLeaf(grid_.node(slot))) bounds_[slot] = 1;
    }
  }

  Events step(const View& view) {
    events_.clear();
    const Metric metric = h_.domain().metric(view);
    metric_ = &metric;
    std::map<int, Undecided> stale_leaves, undecided_addable;
    for (const auto& [slot, bound] : bounds_)
      if (passes(slot, bound) != section_.contains(slot))
        (section_.contains(slot) ? stale_leaves : undecided_addable)[levelOf(slot)].insert({slot, false});
    for (int level = grid_.maxLevel(); level >= 1; --level) remove(stale_leaves[level], stale_leaves[level - 1]);
    for (auto& [level, undecided] : undecided_addable)
      std::erase_if(undecided, [this](const auto& o) { return !bounds_.contains(o.first); });
    std::map<int, std::set<Slot>> arriving;
    for (Slot slot = 0; is_first_ && slot < grid_.slotCount(); ++slot)
      if (isAddable(slot) && !bounds_.contains(slot)) arriving[levelOf(slot)].insert(slot);
    is_first_ = false;
    for (int level = 1; level <= grid_.maxLevel(); ++level)
      add(undecided_addable[level], arriving[level], arriving[level + 1]);
    std::erase_if(pages_, [this](Slot page) { return !isUsed(page); });
    return events_;
  }

  std::vector<Slot> section() const { return {section_.begin(), section_.end()}; }

 private:
  using Undecided = std::map<Slot, bool>;  // is it new?
  struct Resolved {
    Slot slot;
    int least;
    bool is_in;
  };

  bool contains(NodeId n) const { return section_.contains(grid_.slot(n)); }
  bool isLeaf(NodeId n) const {
    const auto children = grid_.children(n);
    return std::none_of(children.begin(), children.end(), [this](NodeId c) { return contains(c); });
  }
  bool isAddable(Slot slot) const {
    const NodeId n = grid_.node(slot);
    if (grid_.isBase(n) || section_.contains(slot)) return false;
    const auto parents = grid_.parents(n);
    return std::all_of(parents.begin(), parents.end(), [this](NodeId p) { return contains(p); });
  }
  int levelOf(Slot slot) const { return grid_.level(grid_.node(slot)); }
  const NodeRecord& record(Slot slot) const { return h_.nodes()[slot]; }

  NodePosition positionOf(Slot slot) const {
    const NodeId n = grid_.node(slot);
    const auto x = static_cast<int32_t>(n.x()), y = static_cast<int32_t>(n.y());
    if (h_.domain().isPlanar()) return PlanarPositions(h_.domain(), *metric_)(x, y, record(slot).middle());
    return CurvedPositions(h_.domain(), *metric_)(x, y, record(slot).middle());
  }
  double radius(Slot slot) const { return h_.domain().radius(levelOf(slot), record(slot).radius()); }
  bool passes(Slot slot, int c) const {
    return metric_->passes(positionOf(slot), radius(slot), QuantisedError{static_cast<uint8_t>(c)}.metres());
  }
  // Passing grows with the class: a search instead of the metric's guess.
  int leastClass(Slot slot) const {
    int least = 256;
    for (int step = 128; step > 0; step /= 2)
      if (passes(slot, least - step)) least -= step;
    return least;
  }

  std::vector<Resolved> resolve(const Undecided& undecided) {
    std::vector<Resolved> resolved;
    size_t predicates_in_group = 0;
    for (const auto& [slot, is_new] : undecided) {
      if (resolved.size() % TerrainBatch::kSize == 0) predicates_in_group = 0;
      const int least = leastClass(slot);
      int& bound = bounds_[slot];
      bool is_in = section_.contains(slot);
      if (least == 256) {
        if (is_in) bound = 255;
        is_in = false;
      } else if (is_in != (bound >= least)) {
        if (predicates_in_group++ == 0) events_.push_back({Event::kGroup});
        events_.push_back({Event::kPredicate, slot, bound, least, is_in, is_new});
        is_in = record(slot).error().value >= least;
        bound = is_in ? least : least - 1;
      }
      resolved.push_back({slot, least, is_in});
    }
    return resolved;
  }

  void remove(const Undecided& stale_leaves, Undecided& above) {
    std::vector<Slot> gone;
    for (const Resolved& s : resolve(stale_leaves))
      if (!s.is_in) gone.push_back(s.slot);
    for (Slot slot : gone) section_.erase(slot);
    for (Slot slot : gone) {
      for (NodeId child : grid_.children(grid_.node(slot))) bounds_.erase(grid_.slot(child));
      for (NodeId parent : grid_.parents(grid_.node(slot))) {
        if (isLeaf(parent) && bounds_.insert({grid_.slot(parent), 1}).second) above.insert({grid_.slot(parent), true});
      }
    }
  }

  void add(Undecided& undecided_addable, const std::set<Slot>& arriving, std::set<Slot>& next) {
    for (Slot slot : arriving) {
      if (pages_.insert(slot / kPageSlots).second) events_.push_back({Event::kRadius, slot});
      bounds_[slot] = 255;
      undecided_addable.insert({slot, true});
    }
    std::vector<Slot> come;
    for (const Resolved& s : resolve(undecided_addable)) {
      if (!s.is_in) continue;
      events_.push_back({Event::kHeight, s.slot, 0, s.least});
      come.push_back(s.slot);
    }
    section_.insert(come.begin(), come.end());
    for (Slot slot : come) {
      for (NodeId parent : grid_.parents(grid_.node(slot))) bounds_.erase(grid_.slot(parent));
      for (NodeId child : grid_.children(grid_.node(slot)))
        if (isAddable(grid_.slot(child))) next.insert(grid_.slot(child));
    }
  }

  bool isUsed(Slot page) const {
    const auto holds = [page](const auto& slots, auto first) {
      return first != slots.end() && slotOf(*first) / kPageSlots == page;
    };
    const Slot first = page * kPageSlots;
    return holds(section_, section_.lower_bound(first)) || holds(bounds_, bounds_.lower_bound(first));
  }
  static Slot slotOf(Slot slot) { return slot; }
  static Slot slotOf(const std::pair<const Slot, int>& entry) { return entry.first; }

  const Hierarchy& h_;
  const GridTopology& grid_;
  const Metric* metric_ = nullptr;  // of the step
  bool is_first_ = true;
  std::set<Slot> section_, pages_;
  std::map<Slot, int> bounds_;
  Events events_;
};

class Predicates : public testing::TestWithParam<FrameKind> {};

TEST_P(Predicates, AreThoseOfAnAdapterThatTestsItsWholeFrontier) {
  const uint64_t seed = testing::UnitTest::GetInstance()->random_seed();
  const Hierarchy hierarchy(test::makeScene(129u, 100u, seed, GetParam()));
  test::Wanderer wanderer(hierarchy, seed);
  TerrainAdapter adapter(hierarchy.domain());
  Reference reference(hierarchy);
  Listener listener(hierarchy);
  AdaptScratch scratch;
  CutDelta delta;
  size_t predicates = 0;
  for (int i = 0; i < 300; ++i) {
    const View view = wanderer.next();
    listener.events.clear();
    ASSERT_TRUE(adapter.adapt(view, hierarchy.grid().slotCount(), listener, scratch, delta));
    const Events expected = reference.step(view);
    ASSERT_TRUE(listener.events == expected) << "seed " << seed << ", step " << i;
    ASSERT_EQ(adapter.section().slots, reference.section()) << "seed " << seed << ", step " << i;
    predicates += expected.size();
  }
  EXPECT_GT(predicates, 0u);
}

TEST_P(Predicates, AreTheSameAfterResumingFromASection) {
  const uint64_t seed = testing::UnitTest::GetInstance()->random_seed();
  const Hierarchy hierarchy(test::makeScene(100u, 60u, seed, GetParam()));
  test::Wanderer wanderer(hierarchy, seed);
  AdaptScratch scratch;
  RefineScratch refine_scratch;
  for (int round = 0; round < 20; ++round) {
    Section held;
    ASSERT_TRUE(refine(hierarchy, wanderer.next(), hierarchy.grid().slotCount(), refine_scratch, held));
    Listener listener(hierarchy);
    TerrainAdapter adapter(hierarchy.domain(), held.slots, listener);
    Reference reference(hierarchy, held);
    for (int i = 0; i < 5; ++i) {
      const View view = wanderer.next();
      listener.events.clear();
      CutDelta delta;
      ASSERT_TRUE(adapter.adapt(view, hierarchy.grid().slotCount(), listener, scratch, delta));
      ASSERT_TRUE(listener.events == reference.step(view)) << "seed " << seed << ", round " << round;
      ASSERT_EQ(adapter.section().slots, reference.section()) << "seed " << seed << ", round " << round;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Frames, Predicates, testing::Values(FrameKind::kPlanar, FrameKind::kGeographic));

}  // namespace
}  // namespace foreland::proto
