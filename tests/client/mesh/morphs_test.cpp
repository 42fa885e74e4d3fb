// The weights of nodes in transition, compared with a table of all nodes that is stepped one by one.
#include "client/mesh/weights/morphs.h"

#include <gtest/gtest.h>

#include <map>
#include <set>

#include "base/rng.h"
#include "proto/topology/grid.h"

namespace foreland::client {
namespace {

using proto::CutDelta;
using proto::NodeId;
using proto::Slot;

class MorphsTest : public testing::Test {
 protected:
  // Adds a node with all its ancestors, or removes one with all its descendants, `changes` times.
  void changeSection(uint64_t changes) {
    while (changes > 0) {
      const NodeId n = grid_.node(static_cast<Slot>(rng_.below(grid_.slotCount())));
      if (grid_.isBase(n)) continue;  // padding
      --changes;
      rng_.below(2) > 0 ? add(n) : remove(n);
    }
  }
  void add(NodeId n) {
    if (!section_.insert(grid_.slot(n)).second) return;
    for (NodeId parent : grid_.parents(n)) add(parent);
  }
  void remove(NodeId n) {
    if (section_.erase(grid_.slot(n)) == 0) return;
    for (NodeId child : grid_.children(n)) remove(child);
  }

  CutDelta change() {
    CutDelta delta;
    proto::diff(last_section_, {{section_.begin(), section_.end()}}, delta);
    last_section_.slots.assign(section_.begin(), section_.end());
    return delta;
  }

  // Steps the table: every node, in transition or not.
  void stepTable(const std::map<Slot, double>& lengths) {
    before_ = to_;
    for (Slot slot = 0; slot < grid_.slotCount(); ++slot) {
      if (grid_.isBase(grid_.node(slot))) continue;
      const double goal = section_.count(slot) ? 1 : 0, length = lengths.at(slot);
      from_[slot] = length > 0 ? to_[slot] : goal;
      const double steps = std::round(std::fabs(goal - from_[slot]) * length);
      to_[slot] = steps > 1 ? from_[slot] + (goal - from_[slot]) / steps : goal;
    }
  }

  // The nodes with a weight, and all their ancestors.
  std::set<Slot> drawnBy(std::map<Slot, double>& weights) const {
    std::set<Slot> drawn;
    const auto draw = [&](auto& self, Slot slot) -> void {
      if (!drawn.insert(slot).second) return;
      for (NodeId parent : grid_.parents(grid_.node(slot))) self(self, grid_.slot(parent));
    };
    for (const auto& [slot, weight] : weights)
      if (weight > 0) draw(draw, slot);
    return drawn;
  }

  static std::set<Slot> applied(const std::set<Slot>& nodes, const CutDelta& delta) {
    const proto::Section next = proto::apply({{nodes.begin(), nodes.end()}}, delta);
    return {next.slots.begin(), next.slots.end()};
  }

  void expectSame() {
    const std::set<Slot> was = drawnBy(before_), from = drawnBy(from_), to = drawnBy(to_);
    ASSERT_EQ(applied(was, morphs_.jumped()), from);
    ASSERT_EQ(applied(from, morphs_.drawn()), to);
    for (Slot slot = 0; slot < grid_.slotCount(); ++slot) {
      const Morph* m = findMorph(morphs_.all(), slot);
      const double rest = section_.count(slot) ? 1 : 0;
      ASSERT_EQ(m ? m->from : rest, from_[slot]) << slot;
      ASSERT_EQ(m ? m->to : rest, to_[slot]) << slot;
      ASSERT_EQ(m                      ? m->in
                : section_.count(slot) ? kInFrom | kInTo
                                       : 0,
                (from.count(slot) ? kInFrom : 0) | (to.count(slot) ? kInTo : 0))
          << slot;
    }
    ASSERT_EQ(morphs_.sectionOf({{to.begin(), to.end()}}).slots, std::vector<Slot>(section_.begin(), section_.end()));
  }

  const uint64_t seed_ = testing::UnitTest::GetInstance()->random_seed();
  Rng rng_{seed_};
  const proto::GridTopology grid_ = proto::GridTopology::create({2, 1, 3, 17, 9}).value();
  std::set<Slot> section_;
  proto::Section last_section_;
  std::map<Slot, double> before_, from_, to_;
  Morphs morphs_;
};

TEST_F(MorphsTest, AreTheTableOfAllNodesThroughAnySectionsAndLengths) {
  SCOPED_TRACE("seed " + std::to_string(seed_));
  size_t turned = 0, late_parents = 0;
  for (int i = 0; i < 300; ++i) {
    changeSection(rng_.below(3) == 0 ? 0 : rng_.below(40));
    std::map<Slot, double> lengths;
    for (Slot slot = 0; slot < grid_.slotCount(); ++slot) lengths[slot] = rng_.below(6) == 0 ? 0 : rng_.uniform(0.5, 9);
    const CutDelta delta = change();
    for (Slot slot : delta.added) turned += to_[slot] > 0;
    for (Slot slot : delta.removed) turned += to_[slot] < 1;
    morphs_.step(grid_, delta, [&](Slot slot) { return lengths.at(slot); });
    stepTable(lengths);
    ASSERT_NO_FATAL_FAILURE(expectSame()) << "step " << i;
    for (const Morph& m : morphs_.all()) late_parents += m.in == (kInFrom | kInTo) && m.from == 0 && m.to == 0;
  }
  EXPECT_GT(turned, 20u) << "no transition was reversed half-way";
  EXPECT_GT(late_parents, 10u) << "no node was drawn for its children's sake";
}

TEST_F(MorphsTest, AtOneIntervalEachAreTheTwoSections) {
  SCOPED_TRACE("seed " + std::to_string(seed_));
  std::set<Slot> last;
  for (int i = 0; i < 100; ++i) {
    changeSection(20);
    morphs_.step(grid_, change(), [](Slot) { return 1.0; });
    EXPECT_FALSE(morphs_.isInTransition());
    ASSERT_TRUE(morphs_.jumped().added.empty() && morphs_.jumped().removed.empty());
    CutDelta expected;
    proto::diff({{last.begin(), last.end()}}, last_section_, expected);
    ASSERT_EQ(morphs_.drawn(), expected);
    for (const Morph& m : morphs_.all()) ASSERT_EQ(weightsOf(m.in), (std::array{m.from, m.to}));
    last = section_;
  }
}

TEST_F(MorphsTest, ReverseFromTheWeightThatTheyHave) {
  const Slot slot = grid_.levelOffset(1);
  const auto step = [&](const CutDelta& delta) {
    morphs_.step(grid_, delta, [](Slot) { return 5.0; });
    return morphs_.all().empty() ? -1 : morphs_.all()[0].to;
  };
  EXPECT_DOUBLE_EQ(step({{slot}, {}}), 0.2);
  EXPECT_DOUBLE_EQ(step({}), 0.4);
  EXPECT_DOUBLE_EQ(step({{}, {slot}}), 0.2);
  EXPECT_DOUBLE_EQ(step({{slot}, {}}), 0.4);
  EXPECT_DOUBLE_EQ(step({{}, {slot}}), 0.2);
  EXPECT_DOUBLE_EQ(step({}), 0);
  EXPECT_FALSE(morphs_.isInTransition());
  EXPECT_EQ(step({}), -1);
}

}  // namespace
}  // namespace foreland::client
