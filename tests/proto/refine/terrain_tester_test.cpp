// Section 10 of docs/PROTOCOL.md: which predicates are decided and which heights are sent, in which order and in which
// groups, follows from the section, what is known and the view, and not from which nodes an adapter chooses to test.
// The reference tests the whole frontier at every step, and remembers in maps.
#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <set>

#include "proto/refine/metric/node_positions.h"
#include "tests/support/scene.h"
#include "tests/support/wanderer.h"

namespace foreland::proto {
namespace {

using server::Hierarchy;

// Bytes to remember pages with.
constexpr uint64_t kSome = 6000, kAll = 1u << 30;

// Something that is sent, or where a group of predicates begins.
struct Event {
  enum Kind : uint8_t { kRadius, kGroup, kPredicate, kHeight, kSettled };
  Kind kind;
  Slot slot = 0;
  int bound = 0, least = 0;
  bool is_in_section = false, is_new = false, is_known = false;
  ClientKnowledge client_knowledge = ClientKnowledge::kNew;
  int finest = 0;
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
      events.push_back({Event::kPredicate, q.slot, q.bound.value, q.least.value, q.is_in_section, q.is_new, q.is_known,
                        q.client_knowledge, q.finest.value});
    return plain_.decide(level, predicates, decisions);
  }
  bool onAdded(int, std::span<const Predicate> added) override {
    for (const Predicate& q : added) events.push_back({Event::kHeight, q.slot, 0, q.least.value});
    return true;
  }
  void onSettled(Slot slot, QuantisedError error) override { events.push_back({Event::kSettled, slot, error.value}); }

 private:
  InMemoryNodes plain_;
};

// Section 10, word for word.
class Reference {
 public:
  // Begins with a section that is held, perhaps the empty one.
  explicit Reference(const Hierarchy& h, uint64_t budget, const Section& held = {})
      : h_(h), grid_(h.grid()), budget_(budget), section_(held.slots.begin(), held.slots.end()) {
    for (Slot slot : section_) {
      pages_[slot / kPageSlots].known.insert(slot);
      pages_[slot / kPageSlots].finest = 0;
      if (isLeaf(grid_.node(slot))) bounds_[slot] = 1;
    }
  }

  Events step(const View& view) {
    events_.clear();
    added_.clear();
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
    for (Slot slot : added_) page(slot).known.insert(slot);
    remember();
    return events_;
  }

  std::vector<Slot> section() const { return {section_.begin(), section_.end()}; }

 private:
  using Undecided = std::map<Slot, bool>;  // is it new?
  struct Page {
    std::set<Slot> known, settled;
    int finest = 255;
    size_t clientBytes() const {
      std::set<Slot> blocks;
      for (Slot slot : known) blocks.insert(slot / 64);
      return 128 + 512 * blocks.size();
    }
  };
  struct Resolved {
    Slot slot;
    bool is_in;
  };

  Page& page(Slot slot) { return pages_.at(slot / kPageSlots); }
  bool isKnown(Slot slot) { return page(slot).known.contains(slot); }
  bool isSettled(Slot slot) { return page(slot).settled.contains(slot); }

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

  ClientKnowledge clientKnowledgeOf(Slot slot, int least) {
    if (isKnown(slot)) return ClientKnowledge::kKnown;
    for (NodeId parent : grid_.parents(grid_.node(slot)))
      if (!isKnown(grid_.slot(parent))) return ClientKnowledge::kNew;
    return page(slot).finest > least ? ClientKnowledge::kSeen : ClientKnowledge::kRejected;
  }

  std::vector<Resolved> resolve(const Undecided& undecided) {
    std::vector<Resolved> resolved;
    std::vector<std::pair<Slot, bool>> all(undecided.begin(), undecided.end());
    for (size_t begin = 0; begin < all.size(); begin += TerrainBatch::kSize)
      resolveGroup(std::span(all).subspan(begin, std::min(TerrainBatch::kSize, all.size() - begin)), resolved);
    return resolved;
  }
  void resolveGroup(std::span<const std::pair<Slot, bool>> group, std::vector<Resolved>& resolved) {
    Events asked;
    const size_t first = resolved.size();
    for (const auto& [slot, is_new] : group) {
      const int least = leastClass(slot);
      int& bound = bounds_[slot];
      bool is_in = section_.contains(slot);
      const bool was_in = is_in;
      if (isSettled(slot))
        bound = record(slot).error().value;
      else if (is_in && bound == 1)
        bound = std::max(1, page(slot).finest);
      if (least == 256) {
        if (is_in && !isSettled(slot)) bound = 255;
        is_in = false;
      } else if (isSettled(slot)) {
        is_in = bound >= least;
      } else if (is_new && !is_in && isKnown(slot) && page(slot).finest >= least) {
        is_in = true;
        bound = page(slot).finest;
      } else if (is_in != (bound >= least)) {
        const ClientKnowledge client_knowledge =
            is_new && !is_in ? clientKnowledgeOf(slot, least) : ClientKnowledge::kNew;
        asked.push_back(
            {Event::kPredicate, slot, bound, least, is_in, is_new, isKnown(slot), client_knowledge, page(slot).finest});
        is_in = record(slot).error().value >= least;
        bound = is_in ? least : least - 1;
      }
      if (was_in) CHECK_TRUE(isKnown(slot));
      resolved.push_back({slot, is_in});
    }
    if (!asked.empty()) events_.push_back({Event::kGroup});
    events_.insert(events_.end(), asked.begin(), asked.end());
    const auto isIn = [&](Slot slot) {
      return std::find_if(resolved.begin() + static_cast<std::ptrdiff_t>(first), resolved.end(),
                          [&](const Resolved& r) { return r.slot == slot; })
          ->is_in;
    };
    for (const Event& e : asked)
      if (!e.is_known && isIn(e.slot)) events_.push_back({Event::kHeight, e.slot, 0, e.least});
    for (const Event& e : asked) settle(e, isIn(e.slot));
  }
  // What the decision and what was known before leave of the error.
  void settle(const Event& e, bool is_in) {
    page(e.slot).finest = std::min(page(e.slot).finest, e.least);
    if (!e.is_known && !is_in) return;
    const int low = is_in             ? e.least
                    : e.is_in_section ? e.bound
                                      : e.finest,
              high = !is_in            ? e.least - 1
                     : e.is_in_section ? 255
                                       : e.bound;
    if (low != high) return;
    EXPECT_EQ(record(e.slot).error().value, low);
    page(e.slot).settled.insert(e.slot);
    events_.push_back({Event::kSettled, e.slot, low});
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
      std::erase(remembered_, slot / kPageSlots);
      if (pages_.try_emplace(slot / kPageSlots).second) events_.push_back({Event::kRadius, slot});
      bounds_[slot] = 255;
      undecided_addable.insert({slot, true});
    }
    std::vector<Slot> come;
    for (const Resolved& s : resolve(undecided_addable)) {
      if (!s.is_in) continue;
      come.push_back(s.slot);
      if (!isKnown(s.slot)) added_.push_back(s.slot);
    }
    section_.insert(come.begin(), come.end());
    for (Slot slot : come) {
      for (NodeId parent : grid_.parents(grid_.node(slot))) bounds_.erase(grid_.slot(parent));
      for (NodeId child : grid_.children(grid_.node(slot)))
        if (isAddable(grid_.slot(child))) next.insert(grid_.slot(child));
    }
  }

  // Pages without nodes that are in use are remembered, those that were used last for longest.
  void remember() {
    for (const auto& [number, page] : pages_)
      if (!isUsed(number) && std::find(remembered_.begin(), remembered_.end(), number) == remembered_.end())
        remembered_.push_back(number);
    const auto bytes = [&] {
      size_t sum = 0;
      for (Slot number : remembered_) sum += pages_.at(number).clientBytes();
      return sum;
    };
    while (bytes() > budget_) {
      pages_.erase(remembered_.front());
      remembered_.erase(remembered_.begin());
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
  uint64_t budget_;
  bool is_first_ = true;
  std::set<Slot> section_;
  std::map<Slot, Page> pages_;    // by slot / kPageSlots
  std::vector<Slot> remembered_;  // of pages_, those that were used last at the end
  std::map<Slot, int> bounds_;
  std::vector<Slot> added_;  // in this step, and not known before
  Events events_;
};

// Frames, and bytes to remember pages with: nothing, a few pages, all of them.
class Predicates : public testing::TestWithParam<std::tuple<FrameKind, uint64_t>> {
 protected:
  FrameKind frame() const { return std::get<0>(GetParam()); }
  uint64_t budget() const { return std::get<1>(GetParam()); }
};

TEST_P(Predicates, AreThoseOfAnAdapterThatTestsItsWholeFrontier) {
  const uint64_t seed = testing::UnitTest::GetInstance()->random_seed();
  const Hierarchy hierarchy(test::makeScene(129u, 100u, seed, frame()));
  test::Wanderer wanderer(hierarchy, seed);
  TerrainAdapter adapter(hierarchy.domain());
  adapter.memory().pages.setBudget(budget());
  Reference reference(hierarchy, budget());
  Listener listener(hierarchy);
  AdaptScratch scratch;
  CutDelta delta;
  size_t predicates = 0, settled = 0;
  for (int i = 0; i < 300; ++i) {
    const View view = wanderer.next();
    listener.events.clear();
    ASSERT_TRUE(adapter.adapt(view, hierarchy.grid().slotCount(), listener, scratch, delta));
    const Events expected = reference.step(view);
    ASSERT_TRUE(listener.events == expected) << "seed " << seed << ", step " << i;
    ASSERT_EQ(adapter.section().slots, reference.section()) << "seed " << seed << ", step " << i;
    predicates += expected.size();
    for (const Event& e : expected) settled += e.kind == Event::kSettled ? 1 : 0;
  }
  EXPECT_GT(predicates, 0u);
  EXPECT_GT(settled, 0u);
}

// The same view twice in a row and again after others: whatever is remembered is not sent again.
TEST_P(Predicates, OfWhatIsRememberedNeedNoHeight) {
  const uint64_t seed = testing::UnitTest::GetInstance()->random_seed();
  const Hierarchy hierarchy(test::makeScene(129u, 100u, seed, frame()));
  test::Wanderer wanderer(hierarchy, seed);
  TerrainAdapter adapter(hierarchy.domain());
  adapter.memory().pages.setBudget(budget());
  Listener listener(hierarchy);
  AdaptScratch scratch;
  std::set<Slot> sent;
  size_t heights = 0, again = 0;
  for (int i = 0; i < 300; ++i) {
    CutDelta delta;
    listener.events.clear();
    ASSERT_TRUE(adapter.adapt(wanderer.next(), hierarchy.grid().slotCount(), listener, scratch, delta));
    for (const Event& e : listener.events) {
      if (e.kind != Event::kHeight) continue;
      ++heights;
      again += sent.insert(e.slot).second ? 0 : 1;
    }
    ASSERT_LE(adapter.memory().pages.clientBytes(), budget());
  }
  EXPECT_GT(heights, 0u);
  if (budget() == kAll)
    EXPECT_EQ(again, 0u) << "seed " << seed;
  else
    EXPECT_GT(again, 0u) << "seed " << seed;
}

TEST_P(Predicates, AreTheSameAfterResumingFromASection) {
  const uint64_t seed = testing::UnitTest::GetInstance()->random_seed();
  const Hierarchy hierarchy(test::makeScene(100u, 60u, seed, frame()));
  test::Wanderer wanderer(hierarchy, seed);
  AdaptScratch scratch;
  RefineScratch refine_scratch;
  for (int round = 0; round < 20; ++round) {
    Section held;
    ASSERT_TRUE(refine(hierarchy, wanderer.next(), hierarchy.grid().slotCount(), refine_scratch, held));
    Listener listener(hierarchy);
    TerrainAdapter adapter(hierarchy.domain(), held.slots, listener);
    adapter.memory().pages.setBudget(budget());
    Reference reference(hierarchy, budget(), held);
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

INSTANTIATE_TEST_SUITE_P(Frames, Predicates,
                         testing::Combine(testing::Values(FrameKind::kPlanar, FrameKind::kGeographic),
                                          testing::Values(uint64_t{0}, kSome, kAll)));

}  // namespace
}  // namespace foreland::proto
