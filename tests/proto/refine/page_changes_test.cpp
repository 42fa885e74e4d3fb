// Changes of a frontier page by page against the same node by node.
#include "proto/refine/page_changes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "base/rng.h"
#include "proto/refine/node_changes.h"

namespace foreland::proto {
namespace {

// A closed section on a random grid with its frontier, as an adapter keeps them.
class RandomFrontier {
 public:
  explicit RandomFrontier(uint64_t seed) : rng_(seed), grid_(makeGrid()) {
    for (int level = 1; level <= grid_.maxLevel(); ++level)
      for (Slot slot = grid_.levelOffset(level); slot < grid_.levelOffset(level + 1); ++slot)
        if (isNode(slot) && hasParents(slot, level) && rng_.below(8) > 0) in_section_.insert(slot);
    for (int level = 1; level <= grid_.maxLevel(); ++level)
      for (Slot slot = grid_.levelOffset(level); slot < grid_.levelOffset(level + 1); ++slot)
        if (isNode(slot) && (in_section_.contains(slot) ? !hasChild(slot, level) : hasParents(slot, level)))
          on_frontier_.insert(slot);
  }

  const GridTopology& grid() const { return grid_; }
  Rng& rng() { return rng_; }
  Frontier frontier() const {
    Frontier frontier(EntryKind::kSwept);
    const auto pageOf = [&](Slot slot) {
      const uint32_t page = frontier.nodes().find(slot);
      return page == Frontier::Nodes::kNone ? frontier.makePage(slot, {}) : page;
    };
    for (Slot slot : in_section_) frontier.addToSection(pageOf(slot), lowOf(slot));
    for (Slot slot : on_frontier_) frontier.put(pageOf(slot), FrontierEntry::newLeaf(lowOf(slot)));
    frontier.orderPages();
    return frontier;
  }
  // Some of the leaves of a level, or of the nodes that can be added.
  std::vector<PagedBits> some(const Frontier& frontier, int level, bool leaves) {
    std::vector<PagedBits> pages;
    const uint64_t one_in = 1 + rng_.below(6);
    for (Slot slot : on_frontier_)
      if (grid_.level(grid_.node(slot)) == level && in_section_.contains(slot) == leaves && rng_.below(one_in) == 0) {
        const uint32_t number = frontier.nodes().find(slot);
        if (pages.empty() || pages.back().number != number) pages.push_back({number, {}});
        pages.back().nodes.set(lowOf(slot));
      }
    return pages;
  }

 private:
  GridTopology makeGrid() {
    const auto log2 = static_cast<uint32_t>(3 + rng_.below(4));
    GridShape shape{.roots_x = static_cast<uint32_t>(1 + rng_.below(3)),
                    .roots_y = static_cast<uint32_t>(1 + rng_.below(3)),
                    .root_log2 = log2};
    shape.samples_x = (shape.roots_x << log2) + 1;
    shape.samples_y = (shape.roots_y << log2) + 1;
    return GridTopology::create(shape).value();
  }
  bool isNode(Slot slot) const { return !grid_.isBase(grid_.node(slot)); }
  bool hasParents(Slot slot, int level) const {
    for (NodeId parent : grid_.parents(grid_.node(slot), level))
      if (!in_section_.contains(grid_.slot(parent, level - 1))) return false;
    return true;
  }
  bool hasChild(Slot slot, int level) const {
    for (NodeId child : grid_.children(grid_.node(slot), level))
      if (in_section_.contains(grid_.slot(child, level + 1))) return true;
    return false;
  }

  Rng rng_;
  GridTopology grid_;
  std::set<Slot> in_section_, on_frontier_;
};

// What a change leaves behind.
struct Outcome {
  std::vector<Slot> in_section, on_frontier, undecided, pending;
  bool operator==(const Outcome&) const = default;
};

template <class Changes>
Outcome outcomeOf(const RandomFrontier& random, int level, const std::vector<PagedBits>& changed, bool removes) {
  Frontier frontier = random.frontier();
  const Frontier::Nodes& nodes = frontier.nodes();
  AdaptScratch scratch;
  scratch.undecided.resize(nodes.pageCount());
  scratch.has_undecided.resize(nodes.pageCount());
  Changes changes(random.grid(), frontier, scratch);
  removes ? changes.remove(level, changed) : changes.add(level, changed);
  Outcome outcome{.in_section = {}, .on_frontier = {}, .undecided = {}, .pending = scratch.pending};
  nodes.forEachInSection([&](Slot slot) { outcome.in_section.push_back(slot); });
  nodes.forEachOnFrontier([&](Slot slot) { outcome.on_frontier.push_back(slot); });
  for (const Frontier::Nodes::PageName& name : nodes.pages()) {
    if (!scratch.has_undecided[name.number]) continue;
    const FrontierPage& page = nodes.page(name.number);
    const SlotBits undecided = scratch.undecided[name.number];
    SlotBits left = undecided;
    if (removes) left = left - changes.innerOf(level - 1, random.grid().pageNodes(level - 1, page.first()), undecided);
    left.forEach([&](uint8_t low) { outcome.undecided.push_back(page.first() | low); });
  }
  std::sort(outcome.pending.begin(), outcome.pending.end());
  outcome.pending.erase(std::unique(outcome.pending.begin(), outcome.pending.end()), outcome.pending.end());
  return outcome;
}

TEST(PageChanges, LeaveTheFrontierThatChangesNodeByNodeLeave) {
  const uint64_t seed = testing::UnitTest::GetInstance()->random_seed();
  RecordProperty("seed", std::to_string(seed));
  for (uint64_t round = 0; round < 25; ++round) {
    RandomFrontier random(seed + round);
    for (int level = 1; level <= random.grid().maxLevel(); ++level)
      for (const bool removes : {true, false}) {
        const auto changed = random.some(random.frontier(), level, removes);
        ASSERT_EQ(outcomeOf<PageChanges>(random, level, changed, removes),
                  outcomeOf<NodeChanges<GridTopology>>(random, level, changed, removes))
            << "seed " << seed + round << ", level " << level << (removes ? ", removed" : ", added");
      }
  }
}

}  // namespace
}  // namespace foreland::proto
