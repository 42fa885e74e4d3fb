// Sparse tables of records: equal to a map, whatever comes and goes.
#include "proto/section/node_tables.h"

#include <gtest/gtest.h>

#include <map>
#include <set>

#include "base/rng.h"

namespace foreland::proto {
namespace {

const GridTopology& grid() {
  static const GridTopology kGrid = GridTopology::create({2, 2, 6, 129, 129}).value();
  return kGrid;
}

TEST(SparseNodes, HoldWhatWasMade) {
  const uint64_t seed = testing::UnitTest::GetInstance()->random_seed();
  SCOPED_TRACE("seed " + std::to_string(seed));
  Rng rng(seed);
  const std::vector<int32_t> corners(9), centres(4);
  SparseNodes nodes(grid(), {corners, centres});
  std::map<Slot, NodeRecord> reference;
  for (int round = 0; round < 30; ++round) {
    const uint64_t reach = uint64_t{1} << rng.below(kSlotBits + 1);  // near slots and far ones
    for (int i = 0; i < 500; ++i) {
      const Slot slot = rng.below(reach);
      const NodeRecord record{rng.next()};
      nodes.make(slot) = record;
      reference[slot] = record;
    }
    std::set<Slot> blocks;
    for (const auto& [slot, record] : reference) {
      ASSERT_EQ(nodes.at(slot), record);
      blocks.insert(slot / SparseNodes::kBlockSlots);
    }
    ASSERT_EQ(nodes.blockCount(), blocks.size() + 1);
    const Slot other = rng.next() >> (64 - kSlotBits);
    if (!blocks.count(other / SparseNodes::kBlockSlots)) {
      ASSERT_EQ(nodes.block(other), SparseNodes::kNone);
      ASSERT_EQ(nodes.at(other), NodeRecord{});
    }
    if (round % 5 != 4) continue;
    std::set<Slot> kept;
    nodes.retain([&](uint32_t block) {
      const bool keep = rng.below(3) > 0;
      if (keep) kept.insert(nodes.first(block) / SparseNodes::kBlockSlots);
      return keep;
    });
    std::erase_if(reference, [&](const auto& entry) { return !kept.count(entry.first / SparseNodes::kBlockSlots); });
    for (Slot block : blocks)
      ASSERT_EQ(nodes.block(block * SparseNodes::kBlockSlots) != SparseNodes::kNone, kept.count(block) == 1);
  }
}

}  // namespace
}  // namespace foreland::proto
