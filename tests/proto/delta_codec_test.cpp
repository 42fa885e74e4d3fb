// Cut deltas: round trip, closure of whatever is decoded, and no bytes that break the decoder.
#include <gtest/gtest.h>

#include <algorithm>

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
    for (NodeId p : grid.parents(n))
      closed = closed && std::binary_search(s.slots.begin(), s.slots.end(), grid.slot(p));
    if (closed) s.slots.push_back(slot);
  }
  return s;
}

class TestNodes final : public HeldNodes {
 public:
  TestNodes(const GridTopology& grid, const Section& section) : grid_(grid), section_(section) {}
  bool has(Slot slot) const override { return std::binary_search(section_.slots.begin(), section_.slots.end(), slot); }
  int32_t height(NodeId v) const override { return heightOf(v); }

 private:
  const GridTopology& grid_;
  const Section& section_;
};

// Knows only what a decoder may ask for.
class StrictNodes final : public HeldNodes {
 public:
  StrictNodes(const GridTopology& grid, const Section& section) : grid_(grid), nodes_(grid, section) {}
  bool has(Slot slot) const override { return nodes_.has(slot); }
  int32_t height(NodeId v) const override {
    EXPECT_TRUE(grid_.isBase(v) || has(grid_.slot(v))) << "a height that the decoder does not hold";
    return heightOf(v);
  }

 private:
  const GridTopology& grid_;
  TestNodes nodes_;
};

Frame planar() {
  Frame frame;
  frame.axis_x_m = {10, 0};
  frame.axis_y_m = {0, 10};
  return frame;
}

DeltaView viewAt(double x, double y) {
  return {.pose = {.eye = {x, y, 3000}}, .tau_px = 1, .ball_m = 30, .turn_rad = 0.01};
}

TEST(DeltaCodec, RoundTripsAnyDeltaBetweenSections) {
  const uint64_t seed = testing::UnitTest::GetInstance()->random_seed() + 1;
  Rng rng(seed);
  const GridTopology grid = *GridTopology::create({3, 2, 4, 45, 30});
  const FrameGrid frame(planar(), grid.maxX(), grid.maxY());
  DeltaModel encoder, decoder;
  Section held;
  for (int i = 0; i < 200; ++i) {
    const Section next = randomSection(grid, rng);
    ASSERT_TRUE(validate(grid, next).ok()) << "seed " << seed;
    CutDelta cut;
    diff(held, next, cut);
    const DeltaView view = viewAt(i * 3.0, 100);
    Bytes bytes;
    encodeDelta(grid, frame, cut, view, TestNodes(grid, next), encoder, bytes);
    HeightDelta got;
    const Status s = decodeDelta(grid, frame, bytes, view, StrictNodes(grid, held), decoder, got);
    ASSERT_TRUE(s.ok()) << "seed " << seed << ": " << s.error().message;
    EXPECT_EQ(got.cut, cut);
    for (size_t k = 0; k < cut.added.size(); ++k) EXPECT_EQ(got.heights[k], heightOf(grid.node(cut.added[k])));
    EXPECT_EQ(apply(held, got.cut), next);
    held = next;
  }
}

TEST(DeltaCodec, AnyBytesEndInADeltaThatFitsOrAnError) {
  const uint64_t seed = testing::UnitTest::GetInstance()->random_seed() + 1;
  Rng rng(seed);
  const GridTopology grid = *GridTopology::create({2, 2, 4, 33, 33});
  const FrameGrid frame(planar(), grid.maxX(), grid.maxY());
  const Section from = randomSection(grid, rng), to = randomSection(grid, rng);
  CutDelta cut;
  diff(from, to, cut);
  Bytes good;
  DeltaModel model;
  encodeDelta(grid, frame, cut, viewAt(0, 0), TestNodes(grid, to), model, good);
  int accepted = 0;
  for (int i = 0; i < 20000; ++i) {
    Bytes bytes = good;
    for (uint64_t k = rng.below(5) + 1; k > 0; --k) bytes[rng.below(bytes.size())] = static_cast<uint8_t>(rng.next());
    bytes.resize(rng.below(bytes.size() + 1));
    HeightDelta out;
    DeltaModel fresh;
    if (!decodeDelta(grid, frame, bytes, viewAt(0, 0), StrictNodes(grid, from), fresh, out).ok()) continue;
    ++accepted;
    ASSERT_EQ(out.heights.size(), out.cut.added.size()) << "seed " << seed;
    ASSERT_TRUE(validate(grid, apply(from, out.cut)).ok()) << "seed " << seed;
    ASSERT_LE(out.cut.added.size(), kNodesPerByte * (bytes.size() + 1));
  }
  EXPECT_GT(accepted, 0);
}

// The bytes are the protocol: if these change, kProtocolVersion does too.
TEST(DeltaCodec, WritesTheBytesOfItsVersion) {
  const GridTopology grid = *GridTopology::create({1, 1, 3, 9, 9});
  const FrameGrid frame(planar(), grid.maxX(), grid.maxY());
  Section to;
  for (Slot slot = 0; slot < grid.levelOffset(4); ++slot)
    if (!grid.isBase(grid.node(slot))) to.slots.push_back(slot);
  CutDelta cut;
  diff({}, to, cut);
  Bytes bytes;
  DeltaModel model;
  encodeDelta(grid, frame, cut, viewAt(40, 40), TestNodes(grid, to), model, bytes);
  uint32_t hash = 0;
  for (uint8_t byte : bytes) hash = fingerprint(hash + byte);
  EXPECT_EQ(bytes.size(), 50u);
  EXPECT_EQ(hash, 3034518899u);
}

// What an empty delta costs: it is the smallest message of a viewer who stands still.
TEST(DeltaCodec, NothingCostsAFewBytes) {
  const GridTopology grid = *GridTopology::create({2, 2, 4, 33, 33});
  const FrameGrid frame(planar(), grid.maxX(), grid.maxY());
  Bytes bytes;
  DeltaModel model;
  encodeDelta(grid, frame, {}, viewAt(0, 0), TestNodes(grid, {}), model, bytes);
  EXPECT_LE(bytes.size(), 4u);
}

}  // namespace
}  // namespace foreland::proto
