// The rasteriser against the definition: a sample lies under a triangle if no edge has it on its outer side.
#include "oracle/block_raster.h"

#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>
#include <glm/vec2.hpp>
#include <memory>

#include "base/rng.h"

namespace foreland::oracle {
namespace {

constexpr uint32_t kBlocks = 2;  // a side
constexpr double kNear = 1e-5;   // a sample so near to an edge may be on either side

double twiceArea(glm::dvec2 a, glm::dvec2 b, glm::dvec2 c) {
  return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
}

// Corners at whole places, or anywhere.
client::KeyframeMesh randomTriangle(Rng& rng, bool is_whole) {
  client::KeyframeMesh mesh;
  for (uint32_t i = 0; i < 3; ++i) {
    const auto place = [&] {
      const double at = rng.uniform(0, kBlocks * kBlock - 1);
      return static_cast<float>(is_whole ? std::round(at) : at);
    };
    mesh.parameters.emplace_back(place(), place());
    const auto metres = [&] { return static_cast<float>(rng.uniform(-100, 100)); };
    mesh.from_positions.emplace_back(metres(), metres(), metres(), 0);
    mesh.to_positions.emplace_back(metres(), metres(), metres(), 0);
    mesh.indices.push_back(i);
  }
  mesh.origin = {1000, -500, 30};
  return mesh;
}

struct Expected {
  bool is_inside = false, is_near_edge = false;
  glm::dvec3 position{};
};

Expected expectedAt(const client::KeyframeMesh& mesh, double weight, double share, glm::dvec2 at) {
  const glm::dvec2 a(mesh.parameters[0]), b(mesh.parameters[1]), c(mesh.parameters[2]);
  const double area = twiceArea(a, b, c), side = area > 0 ? 1 : -1;
  const std::array parts{twiceArea(at, b, c), twiceArea(a, at, c),
                         twiceArea(a, b, at)};  // exact where places are whole
  const double least = std::min({side * parts[0], side * parts[1], side * parts[2]});
  const double longest = std::max({glm::distance(a, b), glm::distance(b, c), glm::distance(c, a)});
  glm::dvec3 position(0);
  for (size_t i = 0; i < 3; ++i) position += parts[i] / area * (mesh.origin + glm::dvec3(mesh.at(i, weight)));
  return {least >= 0, std::fabs(least) / longest < kNear, share * position};
}

// Of one triangle, every block.
void check(const client::KeyframeMesh& mesh, bool is_whole, const std::string& which) {
  constexpr double kWeight = 0.3, kShare = 0.6;
  constexpr std::array<int32_t, kBlocks * kBlocks> kRank{0, 1, 2, 3};
  const auto tile = std::make_unique<Tile>();
  std::array<uint32_t, kBlock> covered;
  BlockRaster raster;
  raster.build(mesh, kWeight, kShare, {kRank, kBlocks, kBlocks, kRank.size()});
  for (uint32_t k = 0; k < kRank.size(); ++k) {
    tile->position.fill({});
    raster.add(k, k % kBlocks, k / kBlocks, *tile, covered);
    for (uint32_t y = 0; y < kBlock; ++y)
      for (uint32_t x = 0; x < kBlock; ++x) {
        const glm::dvec2 at(k % kBlocks * kBlock + x, k / kBlocks * kBlock + y);
        const Expected expected = expectedAt(mesh, kWeight, kShare, at);
        const bool is_covered = covered[y] >> x & 1;
        if (is_whole || !expected.is_near_edge) {
          ASSERT_EQ(is_covered, expected.is_inside) << which << at.x << ' ' << at.y;
        }
        if (!is_covered || !expected.is_inside) continue;
        const auto& found = tile->position[y * kBlock + x].at;
        ASSERT_NEAR(glm::distance(glm::dvec3(found[0], found[1], found[2]), expected.position), 0, 1e-6) << which;
      }
  }
}

TEST(BlockRaster, CoversTheSamplesUnderATriangleAndInterpolatesThere) {
  Rng rng(3);
  for (int round = 0; round < 400; ++round) {
    const bool is_whole = round % 2 == 0;
    const client::KeyframeMesh mesh = randomTriangle(rng, is_whole);
    const glm::dvec2 a(mesh.parameters[0]), b(mesh.parameters[1]), c(mesh.parameters[2]);
    if (std::fabs(twiceArea(a, b, c)) < 0.5) continue;  // as good as a line
    check(mesh, is_whole, "seed 3, round " + std::to_string(round) + ": ");
  }
}

// Triangles with edges along rows, in every order of their corners.
TEST(BlockRaster, CoversTrianglesWithLevelEdges) {
  for (const double apex : {-6.0, 6.0})
    for (int turn = 0; turn < 6; ++turn) {
      Rng rng(8);
      client::KeyframeMesh mesh = randomTriangle(rng, true);
      std::array<glm::vec2, 3> corners{glm::vec2(20, 20), glm::vec2(40, 20), glm::vec2(28, 20 + apex)};
      for (int i = 0; i < turn; ++i)
        std::next_permutation(corners.begin(), corners.end(),
                              [](auto p, auto q) { return std::pair(p.x, p.y) < std::pair(q.x, q.y); });
      std::copy(corners.begin(), corners.end(), mesh.parameters.begin());
      check(mesh, true, "apex " + std::to_string(apex) + ", turn " + std::to_string(turn) + ": ");
    }
}

TEST(BlockRaster, AddsASharedEdgeOnce) {
  client::KeyframeMesh mesh;
  for (const glm::vec2 at : {glm::vec2(0, 0), glm::vec2(8, 0), glm::vec2(8, 8), glm::vec2(0, 8)}) {
    mesh.parameters.push_back(at);
    mesh.from_positions.emplace_back(at, 5, 0);
  }
  mesh.to_positions = mesh.from_positions;
  mesh.indices = {0, 1, 2, 0, 2, 3};
  constexpr std::array<int32_t, 1> kRank{0};
  const auto tile = std::make_unique<Tile>();
  std::array<uint32_t, kBlock> covered;
  BlockRaster raster;
  raster.build(mesh, 0, 1, {kRank, 1, 1, 1});
  tile->position.fill({});
  raster.add(0, 0, 0, *tile, covered);
  for (uint32_t i = 0; i <= 8; ++i) {
    EXPECT_EQ(covered[i], 0x1ffu);
    EXPECT_EQ(tile->position[i * kBlock + i].at, (std::array{1.0 * i, 1.0 * i, 5.0, 0.0}));
  }
}

}  // namespace
}  // namespace foreland::oracle
