// Cut deltas: round trip, and no bytes that break the decoder.
#include <gtest/gtest.h>

#include <map>

#include "base/rng.h"
#include "proto/delta_codec.h"

namespace foreland::proto {
namespace {

int32_t heightOf(NodeId v) { return static_cast<int32_t>(fingerprint(v.x() * 1009 + v.y()) % 60000) - 30000; }

// Grows or shrinks a section at random, always closed.
Section randomSection(const GridTopology& grid, Rng& rng) {
  Section s;
  const uint64_t keep = rng.below(60) + 20;
  for (Slot slot = 0; slot < grid.slotCount(); ++slot) {
    const NodeId n = grid.node(slot);
    if (grid.isBase(n) || rng.below(100) >= keep) continue;
    bool closed = true;
    for (NodeId p : grid.parents(n)) closed = closed && std::binary_search(s.slots.begin(), s.slots.end(), grid.slot(p));
    if (closed) s.slots.push_back(slot);
  }
  return s;
}

TEST(DeltaCodec, RoundTripsAnyDeltaBetweenSections) {
  const uint64_t seed = testing::UnitTest::GetInstance()->random_seed() + 1;
  Rng rng(seed);
  const GridTopology grid = *GridTopology::create({3, 2, 4, 45, 30});
  Section held;
  for (int i = 0; i < 200; ++i) {
    const Section next = randomSection(grid, rng);
    ASSERT_TRUE(validate(grid, next).ok()) << "seed " << seed;
    CutDelta cut;
    diff(held, next, cut);
    Bytes bytes;
    encodeDelta(grid, cut, heightOf, bytes);
    std::map<NodeId, int32_t> known;
    for (Slot s : held.slots) known[grid.node(s)] = heightOf(grid.node(s));
    const auto known_height = [&](NodeId v) -> const int32_t* {
      if (grid.isBase(v)) return &(known[v] = heightOf(v));
      const auto it = known.find(v);
      return it == known.end() ? nullptr : &it->second;
    };
    HeightDelta got;
    const Status s = decodeDelta(grid, bytes, known_height, got);
    ASSERT_TRUE(s.ok()) << "seed " << seed << ": " << s.error().message;
    EXPECT_EQ(got.cut, cut);
    for (size_t k = 0; k < cut.added.size(); ++k) EXPECT_EQ(got.heights[k], heightOf(grid.node(cut.added[k])));
    EXPECT_EQ(apply(held, got.cut), next);
    held = next;
  }
}

TEST(DeltaCodec, AnyBytesEndInADeltaOrAnError) {
  const uint64_t seed = testing::UnitTest::GetInstance()->random_seed() + 1;
  Rng rng(seed);
  const GridTopology grid = *GridTopology::create({2, 2, 4, 33, 33});
  CutDelta cut;
  diff({}, randomSection(grid, rng), cut);
  Bytes good;
  encodeDelta(grid, cut, heightOf, good);
  const int32_t zero = 0;
  const auto base_only = [&](NodeId v) { return grid.isBase(v) ? &zero : nullptr; };
  for (int i = 0; i < 20000; ++i) {
    Bytes bytes = good;
    for (uint64_t k = rng.below(5) + 1; k > 0; --k) bytes[rng.below(bytes.size())] = static_cast<uint8_t>(rng.next());
    bytes.resize(rng.below(bytes.size() + 1));
    HeightDelta out;
    const bool accepted = decodeDelta(grid, bytes, base_only, out).ok();
    EXPECT_TRUE(!accepted || out.heights.size() == out.cut.added.size()) << "seed " << seed;
  }
}

}  // namespace
}  // namespace foreland::proto
