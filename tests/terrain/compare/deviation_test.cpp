// The judge is judged: closest points against a look at every triangle, distances against known ones.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "base/rng.h"
#include "terrain/compare/closest.h"
#include "terrain/compare/deviation.h"
#include "terrain/remesh/original/original.h"
#include "tests/support/models.h"

namespace foreland::terrain {
namespace {

using glm::dvec3;
using Faces = std::vector<Triangle>;

Original original(const Model& model) { return makeOriginal(model).value(); }

// By sampling each triangle densely: an upper bound of the distance, off by no more than the samples' spacing.
double sampledDistance(const dvec3& p, const Original& mesh, int side) {
  double least = INFINITY;
  for (const Triangle& t : mesh.faces)
    for (int i = 0; i <= side; ++i)
      for (int j = 0; i + j <= side; ++j) {
        const double u = double(i) / side, v = double(j) / side;
        least = std::min(least, glm::distance(p, (1 - u - v) * mesh.positions[t[0]] + u * mesh.positions[t[1]] +
                                                     v * mesh.positions[t[2]]));
      }
  return least;
}

TEST(ClosestPoint, IsAsNearAsAnySampleAndLiesOnTheMesh) {
  constexpr uint64_t kSeed = 21;
  SCOPED_TRACE(kSeed);
  Rng rng(kSeed);
  const Original torus = original(test::makeTorus(12, 6));
  const ClosestPoint closest({torus.positions, torus.faces});
  for (int i = 0; i < 300; ++i) {
    const dvec3 p(rng.uniform(-2, 2), rng.uniform(-2, 2), rng.uniform(-1, 1));
    const PointOnMesh at = closest.find(p);
    EXPECT_NEAR(glm::distance(closest.positionOf(at), p), at.distance, 1e-12);
    EXPECT_GE(std::min({at.weights.x, at.weights.y, at.weights.z}), 0);
    EXPECT_NEAR(at.weights.x + at.weights.y + at.weights.z, 1, 1e-12);
    const double sampled = sampledDistance(p, torus, 40);
    EXPECT_LE(at.distance, sampled + 1e-12);
    EXPECT_GT(at.distance, sampled - 0.03);
  }
}

TEST(LargestDistance, OfASphereToALargerOneIsTheDifference) {
  const Original unit = original(test::makeSphere(4));
  Original larger = unit;
  for (dvec3& p : larger.positions) p *= 1.25;
  const MeshView small{unit.positions, unit.faces}, large{larger.positions, larger.faces};
  EXPECT_NEAR(largestDistance(large, ClosestPoint(small), 1e-6, 2), 0.25, 1e-5);
  // From inside, the middles of the larger sphere's flat triangles are nearer than its corners, but its vertices'
  // normals do not hit faces at right angles: bounded by what the facets are off the sphere.
  const double outwards = largestDistance(small, ClosestPoint(large), 1e-6, 2);
  EXPECT_GT(outwards, 0.24);
  EXPECT_LT(outwards, 0.25);
}

// A spike in the middle of a large triangle is seen from one side only at its very tip, from the other only inside of
// it.
TEST(LargestDistance, FindsWhatLiesBetweenVertices) {
  const std::vector<dvec3> flat{{0, 0, 0}, {4, 0, 0}, {0, 4, 0}}, spike{{0, 0, 0}, {4, 0, 0}, {0, 4, 0}, {1, 1, 0.5}};
  const Faces one{{0, 1, 2}}, three{{0, 1, 3}, {1, 2, 3}, {2, 0, 3}};
  const MeshView a{flat, one}, b{spike, three};
  EXPECT_NEAR(largestDistance(b, ClosestPoint(a), 1e-7, 1), 0.5, 1e-9);
  // By symmetry about the tip: the farthest flat point is below it, its nearest face that with the shortest way.
  const double inside = largestDistance(a, ClosestPoint(b), 1e-7, 1);
  double sampled = 0;
  const ClosestPoint to_spike(b);
  for (int i = 0; i <= 400; ++i)
    for (int j = 0; i + j <= 400; ++j) sampled = std::max(sampled, to_spike.find({i / 100.0, j / 100.0, 0}).distance);
  EXPECT_GE(inside, sampled - 1e-7);
  EXPECT_LE(inside, sampled + 0.01);  // no place is farther than that from a sample
}

TEST(LargestDistance, DoesNotDependOnThreads) {
  const Original fine = original(test::makeSphere(4)), coarse = original(test::makeSphere(2));
  const ClosestPoint to({coarse.positions, coarse.faces});
  const double one = largestDistance({fine.positions, fine.faces}, to, 1e-5, 1);
  EXPECT_EQ(one, largestDistance({fine.positions, fine.faces}, to, 1e-5, 3));
}

TEST(Flipped, NamesTurnedAndEmptyTriangles) {
  const Original cube = original(test::makeCube(4));
  const ClosestPoint surface({cube.positions, cube.faces});
  EXPECT_TRUE(findFlipped({cube.positions, cube.faces}, surface, 2).empty());
  Faces faces = cube.faces;
  std::swap(faces[17][0], faces[17][1]);
  faces[3][1] = faces[3][0];
  EXPECT_EQ(findFlipped({cube.positions, faces}, surface, 2), (std::vector<uint32_t>{3, 17}));
}

}  // namespace
}  // namespace foreland::terrain
