// Whatever a server says of blocks, and however it changes its mind: both ends hold the section that refinement from
// scratch gives when it leaves out the nodes that they know to be hidden; that section is closed; and nothing of what
// is known is left over once nothing is hidden.
#include "proto/refine/hidden/hidden_blocks.h"

#include <gtest/gtest.h>

#include <map>
#include <optional>
#include <tuple>

#include "proto/codec/delta_codec.h"
#include "tests/support/block_by_block.h"
#include "tests/support/seed.h"
#include "tests/support/toy_terrain.h"

namespace foreland::proto {
namespace {

// By chance: coarse blocks seldom are hidden, fine ones often; a known block changes now and then.
class Whims final : public test::BlockByBlock {
 public:
  explicit Whims(uint64_t seed) : rng_(seed) {}
  void begin(const View&) override { ++keyframes_; }
  bool isHidden(const BlockId& block) override {
    ++asked_;
    return rng_.below(10) < (block.scale < 2 ? 5u : 1u);
  }
  bool isStillHidden(const BlockId&, bool was_hidden) override {
    const bool changes = rng_.below(10) == 0;
    changed_ += changes ? 1 : 0;
    return was_hidden != changes;
  }
  int asked() const { return asked_; }
  int changed() const { return changed_; }

 private:
  Rng rng_;
  int keyframes_ = 0, asked_ = 0, changed_ = 0;
};

// Nodes by the blocks around them, without the class's arithmetic.
bool isHiddenByDefinition(const GridTopology& grid, const HiddenBlocks& blocks, NodeId n) {
  const uint32_t t = grid.scaleLog2(n);
  const int64_t s = int64_t{1} << t, reach = (n.x() / s % 2 == 1 && n.y() / s % 2 == 1) ? 3 * s : 2 * s, side = 4 * s;
  for (int64_t y = 0; y * side < grid.maxY(); ++y)
    for (int64_t x = 0; x * side < grid.maxX(); ++x) {
      const bool meets = x * side < n.x() + reach && (x + 1) * side > n.x() - reach && y * side < n.y() + reach &&
                         (y + 1) * side > n.y() - reach;
      if (meets && blocks.state({static_cast<uint8_t>(t), static_cast<uint32_t>(x), static_cast<uint32_t>(y)}) !=
                       BlockState::kHidden)
        return false;
    }
  return true;
}

TEST(HiddenBlocks, HideNodesOnlyWithAllOfTheirDescendants) {
  const uint64_t seed = 41;
  SCOPED_TRACE(testing::Message() << "seed " << seed);
  Rng rng(seed);
  const GridTopology grid = GridTopology::create({2, 1, 6, 129, 65}).value();
  HiddenBlocks blocks(grid);
  for (int i = 0; i < 150; ++i) {
    const auto scale = static_cast<uint8_t>(rng.below(6));
    const uint32_t side = BlockId::kSide << scale;
    const BlockId block{scale, static_cast<uint32_t>(rng.below((grid.maxX() + side - 1) / side)),
                        static_cast<uint32_t>(rng.below((grid.maxY() + side - 1) / side))};
    if (blocks.state(block) != BlockState::kHidden) blocks.set(block, rng.below(2u << (2 * scale)) == 0);
  }
  size_t hidden = 0, nodes = 0;
  for (Slot slot = 0; slot < grid.slotCount(); ++slot) {
    const NodeId n = grid.node(slot);
    if (grid.isBase(n)) continue;
    ++nodes;
    const bool is_hidden = blocks.isKnownHidden(n);
    ASSERT_EQ(is_hidden, isHiddenByDefinition(grid, blocks, n)) << n.x() << " " << n.y();
    hidden += is_hidden ? 1 : 0;
    if (!is_hidden) continue;
    for (NodeId child : grid.children(n)) EXPECT_TRUE(blocks.isKnownHidden(child)) << child.x() << " " << child.y();
  }
  EXPECT_GT(hidden, nodes / 20);
  EXPECT_LT(hidden, nodes / 2 + nodes / 3);
}

// In whatever order they came to be known, on a lattice of any size.
TEST(HiddenBlocks, AreVisitedInOrder) {
  const uint64_t seed = test::randomSeed();
  Rng rng(seed);
  const GridTopology grid = *GridTopology::create({7, 7, 15, 200'000, 200'000, 12});
  HiddenBlocks blocks(grid);
  using Tile = std::tuple<uint8_t, uint32_t, uint32_t>;  // scale, row and column of its lowest block
  for (int round = 0; round < 2; ++round) {
    std::map<Tile, int> expected, visited;
    for (int i = 0; i < 2000; ++i) {
      const auto scale = static_cast<uint8_t>(rng.below(15));
      const uint64_t side = uint64_t{BlockId::kSide} << scale, most = rng.below(2) == 0 ? 64 : grid.maxX() / side;
      const BlockId block{scale, static_cast<uint32_t>(rng.below(std::min(most, grid.maxX() / side))),
                          static_cast<uint32_t>(rng.below(std::min(most, grid.maxX() / side)))};
      if (blocks.state(block) != BlockState::kUnknown) continue;
      blocks.set(block, false);
      ++expected[{scale, block.y / 4 * 4, block.x / 4 * 4}];
    }
    std::optional<Tile> last;
    blocks.forEachTile([&](const BlockId& lowest, const HiddenBlocks::Tile& tile) {
      const Tile now{lowest.scale, lowest.y, lowest.x};
      EXPECT_TRUE(!last || *last < now) << "seed " << seed;
      last = now;
      visited[now] = std::popcount(tile.known);
    });
    EXPECT_EQ(visited, expected) << "seed " << seed;
    blocks.clear();
    blocks.forEachTile([](const BlockId&, const HiddenBlocks::Tile&) { FAIL() << "nothing is known"; });
  }
}

// Beside a list of what is known. A coarse block has hundreds of millions of fine ones: none may cost anything that is
// not known.
TEST(HiddenBlocks, AreForgottenWithACoarseOneThatIsHiddenOnALatticeOfAnySize) {
  const uint64_t seed = test::randomSeed();
  Rng rng(seed);
  const GridTopology grid = *GridTopology::create({7, 7, 15, 200'000, 200'000, 12});
  HiddenBlocks blocks(grid);
  std::map<std::tuple<uint8_t, uint32_t, uint32_t>, bool> known;  // scale, row, column
  const auto isIn = [](const BlockId& fine, const BlockId& coarse) {
    const int by = coarse.scale - fine.scale;
    return by > 0 && fine.x >> by == coarse.x && fine.y >> by == coarse.y;
  };
  size_t forgotten = 0;
  for (int i = 0; i < 3000; ++i) {
    const auto scale = static_cast<uint8_t>(rng.below(15));
    const uint64_t side = uint64_t{BlockId::kSide} << scale, last = grid.maxX() / side,
                   most = rng.below(2) == 0 ? std::min<uint64_t>(last, 64) : last;
    const BlockId block{scale, static_cast<uint32_t>(rng.below(most)), static_cast<uint32_t>(rng.below(most))};
    if (blocks.state(block) == BlockState::kHidden) continue;
    const bool is_hidden = rng.below(4) == 0;
    blocks.set(block, is_hidden);
    known[{block.scale, block.y, block.x}] = is_hidden;
    if (is_hidden)
      forgotten += std::erase_if(known, [&](const auto& each) {
        const auto [fine, y, x] = each.first;
        return isIn({fine, x, y}, block);
      });
    ASSERT_EQ(blocks.knownCount(), known.size()) << "seed " << seed << ", step " << i;
  }
  EXPECT_GT(forgotten, 50u);
  size_t visited = 0;
  blocks.forEachTile([&](const BlockId& lowest, const HiddenBlocks::Tile& tile) {
    for (uint32_t i = 0; i < HiddenBlocks::kTileBlocks; ++i)
      if (tile.known >> i & 1) {
        const auto found = known.find({lowest.scale, lowest.y + i / 4, lowest.x + i % 4});
        ASSERT_NE(found, known.end());
        EXPECT_EQ((tile.hidden >> i & 1) != 0, found->second);
        ++visited;
      }
  });
  EXPECT_EQ(visited, known.size()) << "seed " << seed;
}

TEST(HiddenBlocks, AreCountedAndForgotten) {
  const GridTopology grid = GridTopology::create({1, 1, 6, 65, 65}).value();
  HiddenBlocks blocks(grid);
  blocks.set({0, 3, 3}, false);
  blocks.set({0, 2, 3}, true);
  EXPECT_EQ(blocks.knownCount(), 2u);
  EXPECT_EQ(blocks.state({0, 3, 3}), BlockState::kVisible);
  blocks.set({1, 1, 1}, true);
  EXPECT_EQ(blocks.knownCount(), 1u) << "finer blocks are forgotten";
  EXPECT_EQ(blocks.state({0, 3, 3}), BlockState::kHidden) << "by the coarser one that holds it";
  blocks.set({1, 1, 1}, false);
  EXPECT_EQ(blocks.state({0, 3, 3}), BlockState::kUnknown);
  blocks.retainTiles([](const BlockId&) { return false; });
  EXPECT_TRUE(blocks.empty());
}

constexpr uint64_t kMemory = 30'000;  // bytes: less than the terrain has

struct Server {
  explicit Server(const test::ToyTerrain& terrain) : adapter(terrain.domain()) {
    model.signals_blocks = true;
    adapter.memory().pages.setBudget(kMemory);
  }
  TerrainAdapter adapter;
  DeltaModel model;
};
struct Client {
  explicit Client(const test::ToyTerrain& terrain) : adapter(terrain.domain()), nodes(terrain.grid(), terrain.base()) {
    model.signals_blocks = true;
    adapter.memory().pages.setBudget(kMemory);
  }
  TerrainAdapter adapter;
  SparseNodes nodes;
  DeltaModel model;
};

class Seeds : public testing::TestWithParam<uint64_t> {};

TEST_P(Seeds, BothEndsHoldWhatRefinementLeavesOut) {
  const uint64_t seed = GetParam();
  SCOPED_TRACE(testing::Message() << "seed " << seed);
  Rng rng(seed);
  const test::ToyTerrain terrain({2, 2, 6, 129, 129}, seed);
  Server server(terrain);
  Client client(terrain);
  Whims whims(seed);
  AdaptScratch scratch;
  View view;
  view.pose.eye = {600, 600, 400};
  view.lens = {1.0, 640, 360};
  size_t left_out = 0, whole = 0;
  for (int step = 0; step < 120; ++step) {
    view = terrain.wander(rng, view);
    BlockVisibility* visibility = step % 40 < 35 ? &whims : nullptr;  // switched off now and then
    Bytes bytes;
    CutDelta sent, got;
    const DenseNodes table = terrain.table();
    DeltaEncoder encoder(terrain.domain(), table, server.model, bytes, visibility);
    if (visibility) visibility->begin(view);
    ASSERT_TRUE(server.adapter.adapt(view, terrain.nodes().size(), encoder, scratch, sent));
    encoder.finish();
    server.adapter.validate();
    DeltaDecoder decoder(terrain.domain(), client.nodes, client.model, bytes);
    ASSERT_TRUE(client.adapter.adapt(view, terrain.nodes().size(), decoder, scratch, got)) << step;
    ASSERT_TRUE(decoder.finish().ok()) << step;
    client.adapter.validate();
    const Section section = server.adapter.section();
    ASSERT_EQ(section, client.adapter.section()) << step;
    for (const KnownPage& page : client.adapter.knownPages())
      page.knowledge.known.forEach([&](uint8_t low) {
        ASSERT_EQ(client.nodes.at(page.first | low).height(), terrain.nodes()[page.first | low].height());
      });
    ASSERT_EQ(server.adapter.knownPages(), client.adapter.knownPages()) << step;

    const auto& memory = server.adapter.memory();
    ASSERT_EQ(memory.hides, visibility != nullptr);
    RefineScratch refine_scratch;
    Section expected;
    ASSERT_TRUE(refine(terrain.domain(), terrain.nodes(), view, terrain.nodes().size(), refine_scratch, expected,
                       &memory.blocks));
    CutDelta difference;
    diff(section, expected, difference);
    ASSERT_EQ(section, expected) << step << ": " << difference.added.size() << " nodes too few, "
                                 << difference.removed.size() << " too many; the first of level "
                                 << terrain.grid().level(
                                        terrain.grid().node(difference.added.empty()
                                                                ? difference.removed.empty() ? 0 : difference.removed[0]
                                                                : difference.added[0]));
    const Section all = terrain.refine(view);
    if (!visibility) {
      ASSERT_EQ(section, all) << step;
      ASSERT_TRUE(memory.blocks.empty());
    }
    left_out += all.slots.size() - section.slots.size();
    whole += all.slots.size();
    for (Slot slot : section.slots) ASSERT_EQ(client.nodes.at(slot).height(), terrain.nodes()[slot].height());
  }
  EXPECT_GT(left_out, whole / 10);
  EXPECT_GT(whims.asked(), 50);
  EXPECT_GT(whims.changed(), 50);
}

// Whatever the bytes of a delta that tells blocks, the client ends in a closed section or refuses them.
TEST_P(Seeds, HostileBytesEndInAClosedSectionOrARefusal) {
  const uint64_t seed = GetParam();
  SCOPED_TRACE(testing::Message() << "seed " << seed);
  Rng rng(seed);
  const test::ToyTerrain terrain({2, 2, 6, 129, 129}, seed);
  int refused = 0, accepted = 0;
  for (int flight = 0; flight < 25; ++flight) {
    Server server(terrain);
    Client client(terrain);
    Whims whims(seed + flight);
    AdaptScratch scratch;
    View view;
    view.pose.eye = {600, 600, 400};
    view.lens = {1.0, 640, 360};
    for (int step = 0; step < 6; ++step) {
      view = terrain.wander(rng, view);
      Bytes bytes;
      CutDelta delta;
      const DenseNodes table = terrain.table();
      DeltaEncoder encoder(terrain.domain(), table, server.model, bytes, &whims);
      whims.begin(view);
      ASSERT_TRUE(server.adapter.adapt(view, terrain.nodes().size(), encoder, scratch, delta));
      encoder.finish();
      const uint64_t kind = rng.below(8);  // from 3 on they are left as they are
      if (kind == 0 && !bytes.empty()) bytes[rng.below(bytes.size())] ^= static_cast<uint8_t>(1 + rng.below(255));
      if (kind == 1) bytes.resize(rng.below(bytes.size() + 1));
      if (kind == 2)
        for (uint8_t& byte : bytes) byte = static_cast<uint8_t>(rng.next());
      DeltaDecoder decoder(terrain.domain(), client.nodes, client.model, bytes);
      const bool done = client.adapter.adapt(view, kMaxSectionNodes, decoder, scratch, delta) && decoder.finish().ok();
      ASSERT_TRUE(validate(terrain.grid(), client.adapter.section()).ok());
      (done ? accepted : refused) += 1;
      if (!done) break;
      client.adapter.validate();
    }
  }
  EXPECT_GT(refused, 3);
  EXPECT_GT(accepted, 10);
}

INSTANTIATE_TEST_SUITE_P(Some, Seeds, testing::Range<uint64_t>(1, 9));

}  // namespace
}  // namespace foreland::proto
