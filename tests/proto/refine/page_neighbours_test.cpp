// Topology on the bits of pages against children() and parents(), node by node.
#include "proto/refine/page_neighbours.h"

#include <gtest/gtest.h>

#include <set>

#include "base/rng.h"

namespace foreland::proto {
namespace {

GridTopology randomGrid(Rng& rng) {
  if (rng.below(3) == 0)
    return GridTopology::create(GridTopology::cubeShape(static_cast<uint32_t>(1 + rng.below(7)))).value();
  const auto log2 = static_cast<uint32_t>(1 + rng.below(7));
  const auto roots = [&] { return static_cast<uint32_t>(1 + rng.below(log2 > 5 ? 2 : 5)); };
  GridShape shape{.roots_x = roots(), .roots_y = roots(), .root_log2 = log2};
  shape.samples_x = (shape.roots_x << log2) + 1;
  shape.samples_y = (shape.roots_y << log2) + 1;
  return GridTopology::create(shape).value();
}

bool isNode(const GridTopology& grid, Slot slot) { return !grid.isBase(grid.node(slot)); }

// A set of nodes of any density, which need not be closed; pages may be missing.
Frontier::Nodes randomNodes(const GridTopology& grid, Rng& rng) {
  Frontier::Nodes nodes;
  for (Slot first = 0; first < grid.slotCount(); first += kPageSlots) {
    const uint64_t density = rng.below(5);
    if (density == 0) continue;
    const uint32_t page = nodes.makePage(first);
    for (Slot slot = first; slot < first + kPageSlots; ++slot)
      if (isNode(grid, slot) && rng.below(4) < density) nodes.addToSection(page, lowOf(slot));
  }
  nodes.orderPages();
  return nodes;
}

class PageTopology : public testing::Test {
 protected:
  // Calls check(grid, nodes, level, first) for each page of random grids.
  template <class Check>
  void forEachPage(const Check& check) {
    const uint64_t seed = testing::UnitTest::GetInstance()->random_seed();
    RecordProperty("seed", std::to_string(seed));
    Rng rng(seed);
    for (int round = 0; round < 40; ++round) {
      const GridTopology grid = randomGrid(rng);
      const Frontier::Nodes nodes = randomNodes(grid, rng);
      for (int level = 1; level <= grid.maxLevel(); ++level)
        for (Slot first = grid.levelOffset(level); first < grid.levelOffset(level + 1); first += kPageSlots) {
          check(grid, nodes, level, first, rng);
          if (HasFailure()) FAIL() << "seed " << seed << ", round " << round;
        }
    }
  }
};

TEST_F(PageTopology, NamesEachPageByItsPlace) {
  forEachPage([](const GridTopology& grid, const Frontier::Nodes& nodes, int level, Slot first, Rng&) {
    const PageNeighbours neighbours(grid, nodes);
    ASSERT_EQ(neighbours.firstOf(level, neighbours.placeOf(level, first)), first);
  });
}

TEST_F(PageTopology, FindsTheNodesWithAChildInTheSection) {
  forEachPage([](const GridTopology& grid, const Frontier::Nodes& nodes, int level, Slot first, Rng&) {
    const PageNeighbours neighbours(grid, nodes);
    const SlotBits found = neighbours.withChild(level, neighbours.placeOf(level, first));
    for (Slot slot = first; slot < first + kPageSlots; ++slot) {
      if (!isNode(grid, slot)) continue;
      bool any = false;
      for (NodeId child : grid.children(grid.node(slot), level)) any |= nodes.isInSection(grid.slot(child, level + 1));
      ASSERT_EQ(found.has(lowOf(slot)), any) << "level " << level << ", slot " << slot - first;
    }
  });
}

// What stands for no node has no parents.
TEST_F(PageTopology, FindsTheNodesWithAllParentsInTheSection) {
  forEachPage([](const GridTopology& grid, const Frontier::Nodes& nodes, int level, Slot first, Rng&) {
    if (level == 1) return;
    const PageNeighbours neighbours(grid, nodes);
    const SlotBits found = neighbours.withParents(level, neighbours.placeOf(level, first));
    for (Slot slot = first; slot < first + kPageSlots; ++slot) {
      bool all = isNode(grid, slot);
      if (all)
        for (NodeId parent : grid.parents(grid.node(slot), level))
          all = all && nodes.isInSection(grid.slot(parent, level - 1));
      ASSERT_EQ(found.has(lowOf(slot)), all) << "level " << level << ", slot " << slot - first;
    }
  });
}

TEST_F(PageTopology, FindsThePagesOfAllChildrenAndParents) {
  forEachPage([](const GridTopology& grid, const Frontier::Nodes& nodes, int level, Slot first, Rng& rng) {
    const PageNeighbours neighbours(grid, nodes);
    SlotBits some;
    std::set<Slot> below, above;
    for (uint64_t i = rng.below(4); i < 4; ++i) {
      const Slot slot = first + static_cast<Slot>(rng.below(kPageSlots));
      if (!isNode(grid, slot)) continue;
      some.set(lowOf(slot));
      for (NodeId child : grid.children(grid.node(slot), level))
        below.insert(grid.slot(child, level + 1) / kPageSlots * kPageSlots);
      for (NodeId parent : grid.parents(grid.node(slot), level))
        above.insert(grid.slot(parent, level - 1) / kPageSlots * kPageSlots);
    }
    const auto place = neighbours.placeOf(level, first);
    if (some.any()) {
      neighbours.childPages(level, place, some, [&](Slot page) { below.erase(page); });
      neighbours.parentPages(level, place, some, [&](Slot page) { above.erase(page); });
    }
    ASSERT_TRUE(below.empty()) << "level " << level;
    ASSERT_TRUE(above.empty()) << "level " << level;
  });
}

}  // namespace
}  // namespace foreland::proto
