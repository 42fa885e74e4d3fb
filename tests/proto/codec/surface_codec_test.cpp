// What a client reads of objects is what the server has: the same sections, whatever the views, and every node where
// the server has it; and the sections that a server decodes to resume from are those that the client held.
#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

#include "proto/codec/object_stream.h"
#include "proto/codec/section_codec.h"
#include "proto/refine/adapter.h"
#include "terrain/surface/bounds.h"
#include "tests/support/surface_wanderer.h"
#include "tests/support/surfaces.h"

namespace foreland::proto {
namespace {

const GridTopology& smallGrid() {
  static const GridTopology grid = GridTopology::create({1, 1, 1, 3, 3}).value();
  return grid;
}

Epochs fourEpochs() {
  std::vector<Epoch> epochs;
  for (const int64_t time : {0, 3, 10, 11}) epochs.push_back({Time{time}, {}});
  return Epochs::create(smallGrid().shape(), std::move(epochs)).value();
}

ObjectModel modelOf(const terrain::TrueSurface& surface) {
  ObjectModel model{surface.topology.shape(), surface.quantum_m, surface.base, 0};
  for (uint32_t pose = 0; pose <= surface.poses.size() && !surface.poses.empty(); ++pose)
    model.pose_epochs.push_back(pose);
  model.base_moves = terrain::baseMoves(surface);
  return model;
}

// Those of test::surfaces, and one that has poses.
std::vector<test::NamedSurface> surfacesOf(MeshRule rule) {
  const uint32_t halvings = rule == MeshRule::kBisection ? 2 : 3;
  std::vector<test::NamedSurface> all = test::surfaces(rule, halvings);
  all.push_back({"Posed", test::roughSurface(test::baseMeshes().front(), rule, halvings, 0.2, 4)});
  test::addPoses(all.back().surface, 3, 0.5, 0.1, 6);
  return all;
}

// Three objects of one model, so that what is sent of one is known of the others; and both ends.
struct Ends {
  explicit Ends(const test::NamedSurface& named)
      : records(terrain::computeBounds(named.surface, {.threads = 1})),
        moves(terrain::nodeMoves(named.surface)),
        nodes{records, moves, named.surface.poses.size()},
        set(ObjectSet::create({modelOf(named.surface)},
                              {{0, {0, 0, 0}, {1, 0, 0, 0}, 1},
                               {0, {3, 0, 0}, glm::angleAxis(2.0, glm::dvec3(0.6, 0, 0.8)), 1.5},
                               {0, {-1, 2, 0.5}, glm::angleAxis(-0.7, glm::dvec3(0, 1, 0)), 0.3}},
                              fourEpochs())
                .value()),
        server(set),
        client(set) {
    for (size_t i = 0; i < set.size(); ++i) adapters.emplace_back(set.domain(i));
  }

  // The server's change of all objects, and its bytes.
  Bytes write(const View& view) {
    Bytes bytes;
    RangeEncoder out(bytes);
    server.begin(view);
    sent.assign(set.size(), {});
    for (size_t i = 0; i < set.size(); ++i) {
      EXPECT_TRUE(adapters[i].adapt(set.placement(i).toObject(view), set.domain(i).topology().slotCount(), records,
                                    scratch, sent[i]));
      server.encode(i, sent[i], nodes, out, bits);
    }
    out.finish();
    return bytes;
  }
  bool read(const View& view, ByteSpan bytes) {
    RangeDecoder in(bytes);
    client.begin(view);
    got.assign(set.size(), {});
    for (size_t i = 0; i < set.size(); ++i)
      if (!client.decode(i, in, got[i])) return false;
    return in.atEnd();
  }
  HeldSections held() const {
    HeldSections sections;
    for (size_t i = 0; i < set.size(); ++i) sections.objects.push_back(client.section(i));
    return sections;
  }
  testing::AssertionResult agree() const {
    for (size_t i = 0; i < set.size(); ++i) {
      const Section section = client.section(i);
      if (got[i] != sent[i] || section != adapters[i].section() || section != server.section(i))
        return testing::AssertionFailure() << "object " << i << " has another section";
      for (Slot slot : section.slots)
        if (client.position(i, slot) != records[slot].position ||
            !std::ranges::equal(client.moves(i, slot), nodes.movesOf(slot)))
          return testing::AssertionFailure() << "object " << i << " has slot " << slot << " elsewhere";
    }
    return testing::AssertionSuccess();
  }
  // A keyframe from end to end.
  testing::AssertionResult step(const View& view) {
    if (!read(view, write(view))) return testing::AssertionFailure() << "the bytes are refused";
    return agree();
  }
  // A new connection: the client sends its sections, and a new server resumes from them.
  void reconnect() {
    Bytes bytes;
    encodeSections(smallGrid(), set, held(), bytes);
    client.restart();
    const auto decoded = decodeSections(smallGrid(), set, bytes, 1u << 24);
    ASSERT_TRUE(decoded.ok());
    ASSERT_EQ(*decoded, held());
    server = ObjectStream(set);
    for (size_t i = 0; i < set.size(); ++i) {
      adapters[i] = SurfaceAdapter(set.domain(i), decoded->objects[i].slots, records);
      server.hold(i, decoded->objects[i], nodes);
    }
  }

  std::vector<SurfaceRecord> records;
  std::vector<glm::ivec3> moves;
  ModelNodes nodes;
  ObjectSet set;
  std::vector<SurfaceAdapter> adapters;
  ObjectStream server, client;
  AdaptScratch scratch;
  std::vector<CutDelta> sent, got;
  SurfaceBits bits;
};

uint64_t newSeed() {
  const uint64_t seed = static_cast<uint64_t>(testing::UnitTest::GetInstance()->random_seed());
  testing::Test::RecordProperty("seed", std::to_string(seed));
  return seed;
}

class SurfaceCodec : public testing::TestWithParam<MeshRule> {};

TEST_P(SurfaceCodec, GivesTheClientTheServersSectionsAndPositions) {
  const uint64_t seed = newSeed();
  for (const test::NamedSurface& named : surfacesOf(GetParam())) {
    Ends ends(named);
    test::SurfaceWanderer wanderer(seed);
    for (int i = 0; i < 150; ++i) {
      ASSERT_TRUE(ends.step(wanderer.next())) << named.name << ", seed " << seed << ", step " << i;
    }
    EXPECT_LE(ends.bits.positions_sent, ends.bits.added);
  }
}

TEST_P(SurfaceCodec, ResumesFromTheSectionsThatWereHeld) {
  const uint64_t seed = newSeed();
  for (const test::NamedSurface& named : surfacesOf(GetParam())) {
    Ends ends(named);
    test::SurfaceWanderer wanderer(seed);
    for (int i = 0; i < 100; ++i) {
      if (i % 9 == 0) ends.reconnect();
      ASSERT_FALSE(HasFatalFailure());
      ASSERT_TRUE(ends.step(wanderer.next())) << named.name << ", seed " << seed << ", step " << i;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Rules, SurfaceCodec, testing::Values(MeshRule::kQuadrisection, MeshRule::kBisection));

View viewOfAll() {
  View view;
  view.pose = {{0, -6, 0}, lookAlong({0, 1, 0}, {0, 0, 1})};
  view.tau_px = 0.5;
  return view;
}

TEST(SurfaceCodec, SendsAPositionOnceForAllObjectsOfAModel) {
  Ends ends(test::surfaces(MeshRule::kQuadrisection, 4).front());
  ends.write(viewOfAll());
  std::vector<Slot> all;
  for (const CutDelta& delta : ends.sent) all.insert(all.end(), delta.added.begin(), delta.added.end());
  std::sort(all.begin(), all.end());
  const auto distinct = static_cast<uint64_t>(std::unique(all.begin(), all.end()) - all.begin());
  EXPECT_EQ(ends.bits.positions_sent, distinct);
  EXPECT_LT(distinct, ends.bits.added);
}

TEST(SurfaceCodec, SaysNothingOfObjectsThatDoNotChange) {
  Ends ends(test::surfaces(MeshRule::kQuadrisection, 4).front());
  ends.write(viewOfAll());
  ends.write(viewOfAll());
  EXPECT_LE(ends.write(viewOfAll()).size(), 1u);
}

// The server's bytes as they are, with some changed, cut off, or none of them.
Bytes spoiled(Bytes bytes, Rng& rng) {
  const uint64_t kind = rng.below(4);
  if (kind == 1)
    for (uint64_t k = 1 + rng.below(3); k > 0 && !bytes.empty(); --k)
      bytes[rng.below(bytes.size())] = static_cast<uint8_t>(rng.next());
  if (kind == 2) bytes.resize(rng.below(bytes.size() + 1));
  if (kind != 3) return bytes;
  bytes.resize(rng.below(400));
  for (uint8_t& byte : bytes) byte = static_cast<uint8_t>(rng.next());
  return bytes;
}

TEST(SurfaceCodec, EndsInClosedSectionsOrARefusalWhateverTheBytes) {
  const uint64_t seed = newSeed();
  Rng rng(seed);
  const test::NamedSurface sphere = test::surfaces(MeshRule::kQuadrisection, 4).front();
  uint32_t refused = 0, accepted = 0, nodes = 0;
  for (int round = 0; round < 100; ++round) {
    Ends ends(sphere);
    test::SurfaceWanderer wanderer(rng.below(1u << 30));
    for (int i = 0; i < 4; ++i) {
      const View view = wanderer.next();
      if (!ends.read(view, spoiled(ends.write(view), rng))) {
        ++refused;
        break;
      }
      ++accepted;
      for (size_t object = 0; object < ends.set.size(); ++object) {
        ends.client.cut(object).validate();
        nodes += ends.client.cut(object).nodeCount() > 0 ? 1 : 0;
      }
    }
  }
  EXPECT_GT(refused, 10u) << "seed " << seed;
  EXPECT_GT(accepted, 10u) << "seed " << seed;
  EXPECT_GT(nodes, 10u) << "seed " << seed;
}

TEST(HeldSectionsCodec, AreClosedOrRefusedWhateverTheBytes) {
  const uint64_t seed = newSeed();
  Rng rng(seed);
  const Ends ends(test::surfaces(MeshRule::kBisection, 3).front());
  uint32_t taken = 0;
  for (int round = 0; round < 300; ++round) {
    Bytes bytes(rng.below(30));
    for (uint8_t& byte : bytes) byte = static_cast<uint8_t>(rng.below(256));
    const auto sections = decodeSections(smallGrid(), ends.set, bytes, 1u << 20);
    if (!sections.ok()) continue;
    ++taken;
    for (size_t i = 0; i < ends.set.size(); ++i) {
      SurfaceCut cut(ends.set.domain(i).topology());
      cut.hold(sections->objects[i]);
      cut.validate();
      EXPECT_EQ(cut.section(), sections->objects[i]) << "seed " << seed;
    }
  }
  EXPECT_GT(taken, 0u) << "seed " << seed;
}

TEST(HeldSectionsCodec, OfMoreNodesThanAreServedAreRefused) {
  Ends ends(test::surfaces(MeshRule::kQuadrisection, 4).front());
  const View view = viewOfAll();
  ASSERT_TRUE(ends.read(view, ends.write(view)));
  Bytes bytes;
  encodeSections(smallGrid(), ends.set, ends.held(), bytes);
  EXPECT_TRUE(decodeSections(smallGrid(), ends.set, bytes, ends.bits.added).ok());
  EXPECT_FALSE(decodeSections(smallGrid(), ends.set, bytes, ends.bits.added - 1).ok());
}

}  // namespace
}  // namespace foreland::proto
