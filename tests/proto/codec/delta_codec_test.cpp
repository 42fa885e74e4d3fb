// Cut deltas: both ends end where refinement from scratch does, with the same heights, and no bytes break the decoder.
#include <gtest/gtest.h>

#include <algorithm>

#include "proto/codec/delta_codec.h"
#include "tests/support/toy_terrain.h"

namespace foreland::proto {
namespace {

constexpr size_t kNoLimit = 1u << 30;

// One end each.
struct Server {
  explicit Server(const test::ToyTerrain& t) : terrain(t), adapter(t.domain()) {}
  Bytes send(const View& view) {
    Bytes bytes;
    CutDelta delta;
    AdaptScratch scratch;
    const DenseNodes table = terrain.table();
    DeltaEncoder encoder(terrain.domain(), table, model, bytes);
    CHECK_TRUE(adapter.adapt(view, kNoLimit, encoder, scratch, delta));
    encoder.finish();
    return bytes;
  }
  const test::ToyTerrain& terrain;
  TerrainAdapter adapter;
  DeltaModel model;
};

struct Client {
  explicit Client(const test::ToyTerrain& t) : terrain(t), nodes(t.grid(), t.base()), adapter(t.domain()) {}
  Status receive(const View& view, ByteSpan bytes) {
    CutDelta delta;
    AdaptScratch scratch;
    DeltaDecoder decoder(terrain.domain(), nodes, model, bytes);
    const bool done = adapter.adapt(view, kMaxSectionNodes, decoder, scratch, delta);
    if (Status s = decoder.finish(); !s.ok()) return s;
    return done ? Status{} : Error{ErrorCode::kMalformed, "stopped"};
  }
  const test::ToyTerrain& terrain;
  SparseNodes nodes;
  TerrainAdapter adapter;
  DeltaModel model;
};

void expectSame(const test::ToyTerrain& terrain, const Client& client, const View& view, const std::string& where) {
  const Section expected = terrain.refine(view), held = client.adapter.section();
  ASSERT_EQ(held, expected) << where;
  for (Slot slot : held.slots) ASSERT_EQ(client.nodes.at(slot).height(), terrain.nodes()[slot].height()) << where;
}

TEST(DeltaCodec, BothEndsEndWhereRefinementFromScratchDoes) {
  const uint64_t seed = testing::UnitTest::GetInstance()->random_seed();
  Rng rng(seed);
  for (const GridShape& shape : {GridShape{3, 2, 4, 45, 30}, GridShape{1, 1, 6, 65, 65}, GridShape{5, 5, 1, 11, 10},
                                 GridShape{1, 1, 7, 129, 129, 7}, GridShape{2, 1, 6, 100, 60, 10},
                                 GridTopology::cubeShape(5), GridTopology::cubeShape(6, 7)}) {
    const test::ToyTerrain terrain(shape, rng.next());
    Server server(terrain);
    Client client(terrain);
    View view;
    for (int i = 0; i < 150; ++i) {
      view = terrain.wander(rng, view);
      const std::string where = "seed " + std::to_string(seed) + ", step " + std::to_string(i);
      const Status status = client.receive(view, server.send(view));
      ASSERT_TRUE(status.ok()) << where << ": " << status.error().message;
      expectSame(terrain, client, view, where);
      server.adapter.validate();
      client.adapter.validate();
    }
  }
}

// Both ends resume from a section of which they know the nodes alone.
TEST(DeltaCodec, ResumesFromASection) {
  const uint64_t seed = testing::UnitTest::GetInstance()->random_seed();
  Rng rng(seed);
  const test::ToyTerrain whole({2, 2, 5, 65, 60}, rng.next()), sparse({1, 1, 7, 129, 129, 8}, rng.next());
  for (int round = 0; round < 30; ++round) {
    const test::ToyTerrain& terrain = round % 2 == 0 ? whole : sparse;
    Server first(terrain);
    Client client(terrain);
    View view = terrain.wander(rng, {});
    ASSERT_TRUE(client.receive(view, first.send(view)).ok());
    const Section section = client.adapter.section();

    Server second(terrain);
    InMemoryNodes source(terrain.stored());
    second.adapter = TerrainAdapter(terrain.domain(), section.slots, source);
    client.adapter = TerrainAdapter(terrain.domain(), section.slots, source);
    client.model = {};
    for (int i = 0; i < 10; ++i) {
      view = terrain.wander(rng, view);
      const std::string where = "seed " + std::to_string(seed) + ", round " + std::to_string(round);
      ASSERT_TRUE(client.receive(view, second.send(view)).ok()) << where;
      expectSame(terrain, client, view, where);
    }
  }
}

TEST(DeltaCodec, AnyBytesEndInAClosedSectionOrAnError) {
  const uint64_t seed = testing::UnitTest::GetInstance()->random_seed();
  Rng rng(seed);
  const test::ToyTerrain terrain({2, 2, 4, 33, 33}, rng.next());
  int accepted = 0;
  for (int i = 0; i < 3000; ++i) {
    Server server(terrain);
    Client client(terrain);
    View view = terrain.wander(rng, {});
    view.pose.eye = {160, 160, 400};
    for (int step = 0; step < 3; ++step) {
      Bytes bytes = server.send(view);
      if (step > 0 || i % 2 == 0) {
        for (uint64_t k = rng.below(4); k > 0 && !bytes.empty(); --k)
          bytes[rng.below(bytes.size())] = static_cast<uint8_t>(rng.next());
        if (rng.below(3) == 0) bytes.resize(rng.below(bytes.size() + 1));
      }
      const bool ok = client.receive(view, bytes).ok();
      ASSERT_TRUE(validate(terrain.grid(), client.adapter.section()).ok()) << "seed " << seed;
      if (!ok) break;
      ++accepted;
      view = terrain.wander(rng, view);
    }
  }
  EXPECT_GT(accepted, 0);
}

// The bytes are the protocol: if these change, kProtocolVersion does too.
TEST(DeltaCodec, WritesTheBytesOfItsVersion) {
  const test::ToyTerrain terrain({2, 1, 4, 33, 17}, 5);
  Server server(terrain);
  View view;
  view.pose = {{100, 50, 300}, lookAlong({0.6, 0, -0.8}, {0, 0, 1})};
  uint32_t hash = 0;
  size_t size = 0;
  for (int i = 0; i < 4; ++i, view.pose.eye.x += 25) {
    const Bytes bytes = server.send(view);
    size += bytes.size();
    for (uint8_t byte : bytes) hash = fingerprint(hash + byte);
  }
  EXPECT_EQ(size, 509u);
  EXPECT_EQ(hash, 3377521867u);
}

// What an empty delta costs: it is the smallest message of a viewer who stands still.
TEST(DeltaCodec, NothingCostsAFewBytes) {
  const test::ToyTerrain terrain({2, 2, 4, 33, 33}, 6);
  Server server(terrain);
  View view;
  view.pose = {{100, 50, 300}, lookAlong({0.6, 0, -0.8}, {0, 0, 1})};
  server.send(view);
  EXPECT_LE(server.send(view).size(), 1u);
}

}  // namespace
}  // namespace foreland::proto
