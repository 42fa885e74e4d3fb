#include "proto/space/cube_map.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <glm/geometric.hpp>

#include "base/rng.h"
#include "proto/topology/cube.h"
#include "tests/support/seed.h"

namespace foreland::proto {
namespace {

glm::dvec3 vectorAt(const Cube& cube, const CubePlace& p) {
  const double side = cube.side();
  return cubeVector({p.face, 2 * p.x / side - 1, 2 * p.y / side - 1});
}

bool areSameBits(const glm::dvec3& a, const glm::dvec3& b) { return std::memcmp(&a, &b, sizeof(a)) == 0; }

// All ways to name the points of sides, by where they lie: vectors, and positions, have the same bits.
TEST(CubeMap, APointOfASeamHasTheSameBitsFromEachFace) {
  const Spheroid earth(6378137, 6356752.314245179);
  for (const uint32_t log2 : {1u, 5u, 11u}) {
    const Cube cube(log2);
    size_t shared = 0;
    for (uint32_t face = 0; face < Cube::kFaces; ++face)
      for (int32_t r = 0; r <= cube.side(); ++r)
        for (const CubePlace& p : {CubePlace{face, r, 0}, CubePlace{face, r, cube.side()}, CubePlace{face, 0, r},
                                   CubePlace{face, cube.side(), r}}) {
          const CubePlace named = cube.placeOf(cube.name(p));
          ASSERT_TRUE(areSameBits(vectorAt(cube, p), vectorAt(cube, named))) << face << ": " << p.x << ", " << p.y;
          ASSERT_TRUE(
              areSameBits(earth.position(vectorAt(cube, p), 1234.5), earth.position(vectorAt(cube, named), 1234.5)));
          shared += named != p;
        }
    EXPECT_EQ(shared, 12u * (static_cast<size_t>(cube.side()) - 1) + 48 - 2 * 8);
  }
}

TEST(CubeMap, TangentsRunEvenlyAndBackToTheLastBits) {
  EXPECT_EQ(cubeTangent(1), 1);
  EXPECT_EQ(cubeTangent(-1), -1);
  EXPECT_EQ(cubeTangent(0), 0);
  Rng rng(test::randomSeed());
  double last = -1;
  for (int x = 1; x <= 1 << 15; ++x) {
    const double s = 2.0 * x / (1 << 15) - 1, u = cubeTangent(s);
    ASSERT_GT(u, last);
    ASSERT_EQ(cubeTangent(-s), -u);
    ASSERT_NEAR(cubeCoordinate(u), s, 4e-16);
    last = u;
  }
  EXPECT_EQ(cubeCoordinate(1), 1);
  EXPECT_EQ(cubeCoordinate(-1), -1);
}

TEST(CubeMap, VectorsLeadBackToTheirPoint) {
  Rng rng(test::randomSeed());
  for (int i = 0; i < 100'000; ++i) {
    const CubePoint at{static_cast<uint32_t>(rng.below(6)), rng.uniform(-1, 1), rng.uniform(-1, 1)};
    const CubePoint back = cubePoint(cubeVector(at) * rng.uniform(0.1, 1e7));
    ASSERT_EQ(back.face, at.face);
    ASSERT_NEAR(back.s, at.s, 1e-15);
    ASSERT_NEAR(back.t, at.t, 1e-15);
  }
}

// WORLD's figure: a cell is at most 1.47 times as large as another.
TEST(CubeMap, CellsAreNearlyEven) {
  const int side = 64;
  const Spheroid ball(1, 1);
  double least = 1e9, largest = 0;
  const auto at = [&](int x, int y) {
    return ball.position(cubeVector({2, 2.0 * x / side - 1, 2.0 * y / side - 1}), 0);
  };
  for (int x = 0; x < side; ++x)
    for (int y = 0; y < side; ++y) {
      const double area = glm::length(glm::cross(at(x + 1, y + 1) - at(x, y), at(x, y + 1) - at(x + 1, y)));
      least = std::min(least, area);
      largest = std::max(largest, area);
    }
  EXPECT_LT(largest / least, 1.48);
}

}  // namespace
}  // namespace foreland::proto
