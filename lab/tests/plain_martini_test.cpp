// The transcribed MARTINI by the laws of its meshes: they are conforming, cover the square once, hold every sample at
// error 0 and two triangles at an endless error.
#include "lab/martini/plain_martini.h"

#include <gtest/gtest.h>

#include <map>

#include "base/rng.h"

namespace foreland::lab {
namespace {

constexpr uint32_t kSize = 33;

std::vector<float> randomHeights(uint64_t seed) {
  Rng rng(seed);
  std::vector<float> heights(size_t{kSize} * kSize);
  for (float& h : heights) h = static_cast<float>(rng.uniform(0, 100));
  return heights;
}

// Twice the area of all triangles, or 0 if an edge inside the square has not two triangles on opposite sides.
int64_t twiceAreaIfConforming(const PlainMartini::Mesh& mesh) {
  std::map<std::pair<uint32_t, uint32_t>, int> runs;
  int64_t area = 0;
  const auto x = [&](uint32_t v) { return int64_t{mesh.vertices[2 * size_t{v}]}; };
  const auto y = [&](uint32_t v) { return int64_t{mesh.vertices[2 * size_t{v} + 1]}; };
  for (size_t i = 0; i < mesh.triangles.size(); i += 3) {
    const uint32_t a = mesh.triangles[i], b = mesh.triangles[i + 1], c = mesh.triangles[i + 2];
    area += std::abs((x(b) - x(a)) * (y(c) - y(a)) - (x(c) - x(a)) * (y(b) - y(a)));
    for (const auto& edge : {std::pair(a, b), std::pair(b, c), std::pair(c, a)}) ++runs[edge];
  }
  for (const auto& [edge, count] : runs) {
    const auto [a, b] = edge;
    const bool is_border =
        (x(a) == x(b) && (x(a) == 0 || x(a) == kSize - 1)) || (y(a) == y(b) && (y(a) == 0 || y(a) == kSize - 1));
    if (count != 1 || (!is_border && !runs.contains({b, a}))) return 0;
  }
  return area;
}

TEST(PlainMartini, MeshesAreConformingAndCoverTheSquare) {
  const MartiniTables tables(kSize);
  for (uint64_t seed = 1; seed <= 10; ++seed) {
    PlainMartini tile(tables, randomHeights(seed));
    size_t last = 2 * (kSize - 1) * (kSize - 1) + 1;
    for (double error : {1.0, 20.0, 45.0, 60.0}) {
      const PlainMartini::Mesh& mesh = tile.mesh(error);
      EXPECT_EQ(twiceAreaIfConforming(mesh), 2 * (kSize - 1) * (kSize - 1)) << "seed " << seed << ", error " << error;
      EXPECT_LE(mesh.triangleCount(), last) << "seed " << seed << ", error " << error;
      last = mesh.triangleCount();
    }
  }
}

TEST(PlainMartini, HoldsEverySampleWithoutError) {
  const MartiniTables tables(kSize);
  PlainMartini tile(tables, randomHeights(3));
  EXPECT_EQ(tile.mesh(0).triangleCount(), 2u * (kSize - 1) * (kSize - 1));
  EXPECT_EQ(tile.trueError_m(), 0);
  EXPECT_EQ(tile.mesh(tile.largestError_m()).triangleCount(), 2u);
  EXPECT_GT(tile.trueError_m(), 0);
}

TEST(PlainMartini, SplitsWhereASpikeIs) {
  std::vector<float> heights(size_t{kSize} * kSize, 0.0f);
  heights[size_t{5} * kSize + 9] = 10;
  PlainMartini tile(MartiniTables(kSize), heights);
  const PlainMartini::Mesh& mesh = tile.mesh(1);
  EXPECT_EQ(tile.trueError_m(), 0);
  EXPECT_GT(mesh.triangleCount(), 8u);
  EXPECT_LT(mesh.triangleCount(), 80u);
}

}  // namespace
}  // namespace foreland::lab
