// A directory of pages against a set of them: closed under parents, every page found at a place of its own.
#include "proto/section/page_directory.h"

#include <gtest/gtest.h>

#include <set>
#include <string>

#include "base/rng.h"
#include "proto/section/node_tables.h"
#include "tests/support/seed.h"

namespace foreland::proto {
namespace {

// Small ones, with many rows and columns of blocks, and one whose slots exceed 32 bits.
const std::vector<GridShape> kShapes{
    {1, 1, 3, 9, 9, 4}, {3, 1, 5, 97, 33, 8}, {2, 3, 9, 1000, 1500, 6}, {7, 7, 15, 200'000, 200'000, 16}};

Slot pageOf(Slot slot) { return slot - slot % kPageSlots; }

class Directories : public testing::TestWithParam<GridShape> {
 protected:
  Directories() {
    // Nodes near some places, at all scales.
    for (int i = 0; i < 5; ++i) {
      const auto x = static_cast<uint32_t>(rng.below(grid.maxX())), y = static_cast<uint32_t>(rng.below(grid.maxY()));
      const uint64_t reach = 1 + rng.below(std::min(grid.maxX(), grid.maxY()) / 2);
      for (int k = 0; k < 10; ++k) {
        const NodeId n = NodeId::at(std::min<uint32_t>(x + static_cast<uint32_t>(rng.below(reach)), grid.maxX()),
                                    std::min<uint32_t>(y + static_cast<uint32_t>(rng.below(reach)), grid.maxY()));
        if (!grid.isBase(n)) slots.push_back(grid.slot(n));
      }
    }
    blocks = blocksOf(grid, slots);
  }
  // By walking from each node to its parents, and theirs.
  std::set<Slot> closure() const {
    std::set<Slot> pages, open;
    for (const Slot slot : slots) open.insert(pageOf(slot));
    while (!open.empty()) {
      const Slot first = open.extract(open.begin()).value();
      const int level = grid.pagePlace(first).level;
      if (level <= grid.wholeLevels() || !pages.insert(first).second) continue;
      for (Slot slot = first; slot < first + kPageSlots; ++slot)
        if (const NodeId n = grid.node(slot); n != NodeId{})
          for (const NodeId parent : grid.parents(n)) open.insert(pageOf(grid.slot(parent)));
    }
    return pages;
  }

  const uint64_t seed = test::randomSeed();
  Rng rng{seed};
  const GridTopology grid = *GridTopology::create(GetParam());
  std::vector<Slot> slots;
  std::vector<PageBlock> blocks;
};

TEST_P(Directories, HoldPagesAndTheirParentsAndNoOthers) {
  const auto directory = PageDirectory::create(grid, blocks);
  ASSERT_TRUE(directory.ok()) << directory.error().message << ", seed " << seed;
  std::set<Slot> found;
  for (const PageBlock& block : directory->blocks())
    directory->forEachPage(block, [&](Slot first, uint64_t) { found.insert(first); });
  EXPECT_EQ(found, closure()) << "seed " << seed;
  for (const Slot first : found) EXPECT_TRUE(directory->hasPage(first + rng.below(kPageSlots))) << "seed " << seed;
  for (int i = 0; i < 1000; ++i) {
    const Slot slot = rng.below(grid.slotCount());
    EXPECT_EQ(directory->hasPage(slot), slot < directory->wholeSlots() || found.contains(pageOf(slot)));
  }
}

TEST_P(Directories, GiveEveryPageAPlaceOfItsOwn) {
  const auto directory = PageDirectory::create(grid, blocks);
  ASSERT_TRUE(directory.ok());
  EXPECT_EQ(directory->wholeSlots(), grid.levelOffset(grid.wholeLevels() + 1));
  const Slot below = rng.below(directory->wholeSlots());
  EXPECT_EQ(directory->placeOf(below), below);
  uint64_t next = directory->wholeSlots() / kPageSlots;
  for (const PageBlock& block : directory->blocks())
    directory->forEachPage(block, [&](Slot first, uint64_t place) {
      EXPECT_EQ(place, next++) << "seed " << seed;
      const uint64_t low = rng.below(kPageSlots);
      EXPECT_EQ(directory->placeOf(first + low), place * kPageSlots + low) << "seed " << seed;
    });
  EXPECT_EQ(directory->pageCount(), next);
}

TEST_P(Directories, RefuseWhatContradictsItself) {
  const auto isRefused = [&](const auto& change) {
    std::vector<PageBlock> changed = blocks;
    change(changed);
    return !PageDirectory::create(grid, changed).ok();
  };
  ASSERT_FALSE(blocks.empty());
  EXPECT_TRUE(isRefused([](auto& b) { b.push_back(b.back()); }));
  EXPECT_TRUE(isRefused([](auto& b) { b.back().first += 1; }));
  EXPECT_TRUE(isRefused([](auto& b) { b.back().bits = {}; }));
  EXPECT_TRUE(isRefused([this](auto& b) { b.front().key = PageBlock::keyOf(grid.wholeLevels(), 0, 0); }));
  EXPECT_TRUE(isRefused([this](auto& b) { b.back().key = PageBlock::keyOf(grid.maxLevel() + 1, 0, 0); }));
  EXPECT_TRUE(isRefused(
      [this](auto& b) { b.back().key = PageBlock::keyOf(grid.maxLevel(), grid.pageColumns(grid.maxLevel()), 0); }));
  if (grid.pageColumns(grid.maxLevel()) % PageBlock::kSide != 0) {
    EXPECT_TRUE(isRefused([this](auto& b) {
      const int level = grid.maxLevel();
      PageBlock& last = b.emplace_back();
      last.key = PageBlock::keyOf(level, grid.pageColumns(level) / PageBlock::kSide, grid.pageRows(level) / 32);
      last.first = b[b.size() - 2].first + b[b.size() - 2].count();
      last.bits[15] = uint64_t{1} << 63;
    }));
  }
}

INSTANTIATE_TEST_SUITE_P(Shapes, Directories, testing::ValuesIn(kShapes));

TEST(StoredNodes, ReadAsZerosWhereNoPageIs) {
  const uint64_t seed = test::randomSeed();
  Rng rng(seed);
  const GridTopology grid = *GridTopology::create({2, 2, 7, 200, 257, 5});
  std::vector<Slot> some;
  for (int i = 0; i < 3; ++i) some.push_back(rng.below(grid.slotCount()));
  const std::vector<PageBlock> blocks = blocksOf(grid, some);
  const auto directory = PageDirectory::create(grid, blocks);
  ASSERT_TRUE(directory.ok());
  std::vector<NodeRecord> records(directory->pageCount() * kPageSlots);
  for (NodeRecord& record : records) record.bits = rng.next();
  const StoredNodes nodes(records, *directory);
  for (Slot slot = 0; slot < grid.slotCount(); ++slot) {
    const uint64_t place = directory->placeOf(slot);
    ASSERT_EQ(nodes.hasPage(slot), place != PageDirectory::kNowhere);
    ASSERT_EQ(nodes[slot], nodes.hasPage(slot) ? records[place] : NodeRecord{}) << "seed " << seed;
  }
}

}  // namespace
}  // namespace foreland::proto
