// Other makers' codecs give back what they were given to their stated tolerance; if they are given another mesh, the
// judge finds out.
#include <gtest/gtest.h>
#include <zlib.h>

#include <fstream>
#include <glm/vector_relational.hpp>

#include "lab/tests/peer_meshes.h"
#include "lab/wire/held_mesh.h"
#include "lab/wire/peers/draco_peer.h"
#include "lab/wire/peers/entropy.h"
#include "lab/wire/peers/match.h"
#include "lab/wire/peers/meshoptimizer_peer.h"
#include "lab/wire/peers/quantized_mesh.h"
#include "tests/support/scene.h"

namespace foreland::lab {
namespace {

using test::roughGrid;

Bytes gunzip(const Bytes& bytes) {
  z_stream stream{};
  CHECK_EQ(inflateInit2(&stream, 16 + MAX_WBITS), Z_OK);
  Bytes out(size_t{4} << 20);
  stream.next_in = const_cast<uint8_t*>(bytes.data());
  stream.avail_in = static_cast<uInt>(bytes.size());
  stream.next_out = out.data();
  stream.avail_out = static_cast<uInt>(out.size());
  CHECK_EQ(inflate(&stream, Z_FINISH), Z_STREAM_END);
  out.resize(stream.total_out);
  inflateEnd(&stream);
  return out;
}

// A reader of the format as https://github.com/CesiumGS/quantized-mesh describes it; shares nothing with the encoder.
class TileReader {
 public:
  explicit TileReader(Bytes tile) : tile_(std::move(tile)) {}

  PeerMesh read(const Box& box) {
    at_ = 24;
    const double lowest = take<float>(), highest = take<float>();
    at_ = 88;
    const auto count = take<uint32_t>();
    PeerMesh mesh;
    mesh.positions.resize(count);
    const glm::dvec3 low(box.low.x, box.low.y, lowest), high(box.high.x, box.high.y, highest);
    for (int axis = 0; axis < 3; ++axis) {
      int value = 0;
      for (glm::dvec3& p : mesh.positions) {
        const int code = take<uint16_t>();
        value += code % 2 == 0 ? code / 2 : -(code + 1) / 2;
        p[axis] = low[axis] + (high[axis] - low[axis]) * value / 32767.0;
      }
    }
    count > 65536 ? readIndices<uint32_t>(mesh) : readIndices<uint16_t>(mesh);
    return mesh;
  }
  std::array<std::vector<uint32_t>, 4> edges;  // west, south, east, north
  bool isAtEnd() const { return at_ == tile_.size(); }

 private:
  template <class T>
  T take() {
    T value;
    CHECK_LE(at_ + sizeof(T), tile_.size());
    std::memcpy(&value, tile_.data() + at_, sizeof(T));
    at_ += sizeof(T);
    return value;
  }
  template <class Index>
  void readIndices(PeerMesh& mesh) {
    while (at_ % sizeof(Index) != 0) ++at_;
    mesh.indices.resize(3 * size_t{take<uint32_t>()});
    uint32_t unused = 0;
    for (uint32_t& index : mesh.indices) {
      const auto code = take<Index>();
      index = unused - code;
      if (code == 0) ++unused;
    }
    for (auto& edge : edges) {
      edge.resize(take<uint32_t>());
      for (uint32_t& index : edge) index = take<Index>();
    }
  }

  Bytes tile_;
  size_t at_ = 0;
};

Result<PeerCode> codeTile(const PeerMesh& mesh) {
  const Box box = boxAround(mesh);
  PeerCode code{.bytes = gzip(encodeQuantizedMesh(mesh)), .decoded = {}, .tolerance = {}};
  code.decoded = TileReader(gunzip(code.bytes)).read(box);
  code.tolerance = (box.high - box.low) * 0.50001 / 32767.0;
  return code;
}

struct Codec {
  const char* name;
  Result<PeerCode> (*code)(const PeerMesh&);
};

void PrintTo(const Codec& c, std::ostream* out) { *out << c.name; }

class EveryCodec : public testing::TestWithParam<Codec> {};

TEST_P(EveryCodec, GivesBackWhatItWasGiven) {
  const int seed = testing::UnitTest::GetInstance()->random_seed();
  Rng rng(static_cast<uint64_t>(seed) + 1);
  for (const auto& [width, height] : {std::pair{2u, 2u}, {3u, 17u}, {40u, 31u}, {120u, 90u}}) {
    const PeerMesh mesh = roughGrid(width, height, rng);
    const auto code = GetParam().code(mesh);
    ASSERT_TRUE(code.ok()) << code.error().message;
    const auto match = matchMeshes(mesh, *code);
    ASSERT_TRUE(match.ok()) << match.error().message << "; --gtest_random_seed=" << seed << ", " << width << " x "
                            << height;
    EXPECT_EQ(match->size(), mesh.positions.size());
    EXPECT_TRUE(glm::all(glm::lessThan(code->tolerance, glm::dvec3(0.2)))) << "too coarse to mean anything";
  }
}

TEST_P(EveryCodec, IsFoundOutWhenFedAnotherMesh) {
  const int seed = testing::UnitTest::GetInstance()->random_seed();
  Rng rng(static_cast<uint64_t>(seed) + 1);
  const PeerMesh mesh = roughGrid(40, 31, rng);
  const auto whole = GetParam().code(mesh);
  ASSERT_TRUE(whole.ok());
  for (const test::Damage& damage : test::damages())
    for (int round = 0; round < 10; ++round) {
      PeerMesh damaged = mesh;
      damage.apply(damaged, whole->tolerance, rng);
      const auto code = GetParam().code(damaged);
      EXPECT_FALSE(code.ok() && matchMeshes(mesh, *code).ok()) << damage.name << "; --gtest_random_seed=" << seed;
    }
}

TEST_P(EveryCodec, TakesTheMeshesThatAClientHolds) {
  for (const auto kind : {proto::FrameKind::kPlanar, proto::FrameKind::kGeographic}) {
    const server::Hierarchy hierarchy(test::makeScene(201, 117, 5, kind));
    proto::View view;
    view.pose.eye = {0, 0, 2500};
    for (double tau_px : {4.0, 1.0}) {
      view.tau_px = tau_px;
      const PeerMesh mesh = meshHeldFor(hierarchy, view).lattice;
      const auto code = GetParam().code(mesh);
      ASSERT_TRUE(code.ok()) << code.error().message;
      const auto match = matchMeshes(mesh, *code);
      EXPECT_TRUE(match.ok()) << match.error().message;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Peers, EveryCodec,
                         testing::Values(Codec{"quantized_mesh", codeTile}, Codec{"meshoptimizer", codeMeshoptimizer},
                                         Codec{"meshoptimizer_exact", codeMeshoptimizerExactly},
                                         Codec{"draco", codeDraco}, Codec{"draco_exact", codeDracoExactly}));

TEST(QuantizedMesh, HasItsEdgesAndEndsWithThem) {
  Rng rng(2);
  const PeerMesh mesh = roughGrid(30, 20, rng);
  TileReader tile(encodeQuantizedMesh(mesh));
  const PeerMesh read = tile.read(boxAround(mesh));
  EXPECT_TRUE(tile.isAtEnd());
  const std::array<std::pair<int, double>, 4> sides{{{0, 0}, {1, 0}, {0, 29}, {1, 19}}};
  for (size_t i = 0; i < 4; ++i) {
    EXPECT_EQ(tile.edges[i].size(), i % 2 == 0 ? 20u : 30u);
    for (uint32_t v : tile.edges[i]) EXPECT_EQ(read.positions[v][sides[i].first], sides[i].second);
  }
}

TEST(QuantizedMesh, HasLongIndicesWhereShortOnesDoNotReach) {
  Rng rng(3);
  for (const auto& [width, height] : {std::pair{256u, 256u}, {257u, 256u}, {257u, 255u}}) {
    const PeerMesh mesh = roughGrid(width, height, rng);
    const auto match = matchMeshes(mesh, *codeTile(mesh));
    EXPECT_TRUE(match.ok()) << match.error().message;
  }
}

// With somebody else's decoder; runs where it is installed.
TEST(QuantizedMesh, IsReadByTheDecoderFromNpm) {
  Rng rng(4);
  for (const auto& [width, height] : {std::pair{30u, 20u}, {257u, 256u}}) {
    const PeerMesh mesh = roughGrid(width, height, rng);
    const auto code = codeQuantizedMesh(mesh, quantizedMeshSources());
    if (!code && code.error().code == ErrorCode::kNotFound) GTEST_SKIP() << code.error().message;
    ASSERT_TRUE(code.ok()) << code.error().message;
    const auto match = matchMeshes(mesh, *code);
    EXPECT_TRUE(match.ok()) << match.error().message;
  }
}

TEST(QuantizedMesh, SaysHowToInstallItsDecoder) {
  const test::TemporaryFolder empty;
  Rng rng(5);
  const auto code = codeQuantizedMesh(roughGrid(3, 3, rng), empty.path());
  ASSERT_FALSE(code.ok());
  EXPECT_EQ(code.error().code, ErrorCode::kNotFound);
  EXPECT_NE(code.error().message.find("npm ci --prefix " + empty.path().string()), std::string::npos);
}

TEST(ExactCodecs, MoveNothing) {
  Rng rng(6);
  PeerMesh mesh = roughGrid(50, 50, rng);
  for (const double farthest : {1000.0, 100'000.0}) {  // the latter needs more than 16 bits
    mesh.positions[7].z = farthest;
    for (const auto& codec : {codeDracoExactly, codeMeshoptimizerExactly}) {
      const auto code = codec(mesh);
      ASSERT_TRUE(code.ok());
      EXPECT_EQ(code->tolerance, glm::dvec3(0));
      const auto match = matchMeshes(mesh, *code);
      ASSERT_TRUE(match.ok());
      for (size_t i = 0; i < match->size(); ++i) EXPECT_EQ(code->decoded.positions[i], mesh.positions[(*match)[i]]);
    }
  }
}

TEST(MatchMeshes, AllowsNewNamesAndTurnedCorners) {
  Rng rng(7);
  const PeerMesh mesh = roughGrid(9, 9, rng);
  PeerCode code{.bytes = {}, .decoded = mesh};
  std::reverse(code.decoded.positions.begin(), code.decoded.positions.end());
  for (uint32_t& v : code.decoded.indices) v = static_cast<uint32_t>(mesh.positions.size()) - 1 - v;
  for (size_t i = 0; i < code.decoded.indices.size(); i += 3)
    std::rotate(code.decoded.indices.begin() + static_cast<ptrdiff_t>(i),
                code.decoded.indices.begin() + static_cast<ptrdiff_t>(i + 1 + i % 2),
                code.decoded.indices.begin() + static_cast<ptrdiff_t>(i + 3));
  const auto match = matchMeshes(mesh, code);
  ASSERT_TRUE(match.ok()) << match.error().message;
  for (size_t i = 0; i < match->size(); ++i) EXPECT_EQ((*match)[i], match->size() - 1 - i);
}

TEST(MatchMeshes, HoldsEachAxisToItsTolerance) {
  Rng rng(8);
  const PeerMesh mesh = roughGrid(9, 9, rng);
  const glm::dvec3 tolerance(0.1, 0.2, 3);
  for (int axis = 0; axis < 3; ++axis)
    for (double share : {-1.01, -0.99, 0.99, 1.01}) {
      PeerCode code{.bytes = {}, .decoded = mesh, .tolerance = tolerance};
      code.decoded.positions[rng.below(81)][axis] += share * tolerance[axis];
      EXPECT_EQ(matchMeshes(mesh, code).ok(), std::fabs(share) < 1) << axis << ' ' << share;
    }
}

TEST(MatchMeshes, FindsIndicesThatLeadNowhere) {
  Rng rng(9);
  const PeerMesh mesh = roughGrid(3, 3, rng);
  PeerCode code{.bytes = {}, .decoded = mesh};
  code.decoded.indices[4] = 9;
  EXPECT_FALSE(matchMeshes(mesh, code).ok());
}

TEST(OrderZeroEntropy, IsTheLogarithmOfTheNumberOfEquallyOftenValues) {
  std::vector<int32_t> values;
  for (int32_t v = 0; v < 64; ++v) values.insert(values.end(), 5, v * 1000 - 32000);
  Rng rng(10);
  for (size_t i = values.size() - 1; i > 0; --i) std::swap(values[i], values[rng.below(i + 1)]);
  EXPECT_NEAR(orderZeroEntropyBits(values), 6, 1e-12);
  EXPECT_EQ(orderZeroEntropyBits({}), 0);
  EXPECT_EQ(orderZeroEntropyBits(std::vector<int32_t>(7, -3)), 0);
  const std::vector<int32_t> uneven{1, 1, 1, 2};
  EXPECT_NEAR(orderZeroEntropyBits(uneven), 2 - 0.75 * std::log2(3), 1e-12);
}

TEST(MeshHeldFor, IsTheClientsMeshInBothSpaces) {
  const auto scene = test::makeScene(65, 65, 9);
  const server::Hierarchy hierarchy(scene);
  proto::View view;
  view.pose.eye = {0, 0, 1500};
  const HeldMesh held = meshHeldFor(hierarchy, view);
  ASSERT_EQ(held.lattice.positions.size(), held.scene.positions.size());
  EXPECT_EQ(held.lattice.indices, held.scene.indices);
  EXPECT_GT(held.heights.size(), 500u);
  EXPECT_EQ(held.displacements.size(), held.heights.size());
  EXPECT_GT(held.bytes, held.heights.size() / 4);
  const proto::FrameTransform transform(scene->frame());
  const auto inScene = [&](const glm::dvec3& p) {
    return transform.toScene(proto::LatticePosition{p.x, p.y, p.z * scene->frame().height_quantum_m});
  };
  const glm::dvec3 origin = inScene(held.lattice.positions[0]) - held.scene.positions[0];
  std::vector<int32_t> heights, nodes = held.heights;
  for (size_t i = 0; i < held.lattice.positions.size(); ++i) {
    const glm::dvec3& p = held.lattice.positions[i];
    EXPECT_LE(glm::distance(inScene(p) - origin, held.scene.positions[i]), 1e-3);
    if (!scene->grid().isBase(proto::NodeId::at(static_cast<uint32_t>(p.x), static_cast<uint32_t>(p.y))))
      heights.push_back(static_cast<int32_t>(p.z));
  }
  std::sort(heights.begin(), heights.end());
  std::sort(nodes.begin(), nodes.end());
  EXPECT_EQ(heights, nodes);
}

}  // namespace
}  // namespace foreland::lab
