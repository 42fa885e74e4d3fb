// What may be remeshed, and what the errors name.
#include "terrain/remesh/original/original.h"

#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>
#include <string>

#include "base/rng.h"
#include "terrain/remesh/original/triangulate.h"
#include "tests/support/models.h"

namespace foreland::terrain {
namespace {

using glm::dvec3;
using Faces = std::vector<std::vector<uint32_t>>;

void expectRefusal(const Model& model, const std::string& words) {
  const auto made = makeOriginal(model);
  ASSERT_FALSE(made.ok()) << words;
  EXPECT_NE(made.error().message.find(words), std::string::npos) << made.error().message;
}

const std::vector<dvec3> kSquare{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0, 0, 1}};

TEST(Original, NamesWhatIsNoSurface) {
  expectRefusal(test::makeModel(kSquare, {{0, 1, 2}, {0, 1, 3}, {1, 0, 4}}),
                "face 2 shares its edge from vertex 1 to vertex 0");
  expectRefusal(test::makeModel(kSquare, {{0, 1, 2}, {0, 2, 1}}), "face 1 has the same corners as face 0");
  expectRefusal(test::makeModel(kSquare, {{0, 1, 2}, {0, 3, 3}}), "face 1 has two corners at the position of vertex 3");
  expectRefusal(test::makeModel({{0, 0, 0}, {1, 0, 0}, {2, 0, 0}}, {{0, 1, 2}}), "face 0 has no area");
  expectRefusal(test::makeModel(kSquare, {{0, 2, 1, 3}}), "face 0 has no area or crosses itself");
  expectRefusal(test::makeModel({{0, 0, 0}, {1e-12, 0, 0}, {0, 1e-12, 0}}, {{0, 1, 2}}), "smaller than 1e-9");
  // Two tetrahedra that share a vertex.
  expectRefusal(
      test::makeModel({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {-1, 0, 0}, {0, -1, 0}, {0, 0, -1}},
                      {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}, {0, 4, 5}, {0, 6, 4}, {0, 5, 6}, {4, 6, 5}}),
      "vertex 0 joins parts of the surface that touch in this point only");
}

TEST(Original, NamesTheFaceWhereAOneSidedSurfaceCloses) {
  std::vector<dvec3> p;
  Faces faces;
  constexpr uint32_t kCount = 12;
  for (uint32_t i = 0; i < kCount; ++i) {
    const double turn = 2 * std::numbers::pi * i / kCount;
    const dvec3 out(std::cos(turn), std::sin(turn), 0);
    const dvec3 across = std::cos(turn / 2) * dvec3(0, 0, 1) + std::sin(turn / 2) * out;
    p.push_back(3.0 * out - across), p.push_back(3.0 * out + across);
    if (i + 1 < kCount) faces.push_back({2 * i, 2 * i + 2, 2 * i + 3, 2 * i + 1});
  }
  faces.push_back({2 * kCount - 2, 1, 0, 2 * kCount - 1});
  expectRefusal(test::makeModel(p, faces), "one side only");
}

TEST(Original, WeldsAndPartsAgain) {
  const auto cube = makeOriginal(test::makeCube(3));
  ASSERT_TRUE(cube.ok());
  EXPECT_EQ(cube->positions.size(), 6u * 9 + 2);
  EXPECT_EQ(cube->welded, 6u * 16 - (6u * 9 + 2));
  for (const Triangle& t : cube->twins)
    for (uint32_t beyond : t) EXPECT_NE(beyond, kNoIndex);
  // Two tetrahedra with a vertex each at the same place stay apart there.
  const auto two = makeOriginal(
      test::makeModel({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0, 0, 0}, {-1, 0, 0}, {0, -1, 0}, {0, 0, -1}},
                      {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}, {4, 5, 6}, {4, 7, 5}, {4, 6, 7}, {5, 7, 6}}));
  ASSERT_TRUE(two.ok()) << two.error().message;
  EXPECT_EQ(two->positions.size(), 8u);
}

TEST(Original, TurnsFacesTheSameWayAndClosedSurfacesOutside) {
  constexpr uint64_t kSeed = 5;
  SCOPED_TRACE(kSeed);
  Rng rng(kSeed);
  for (const double share : {0.2, 0.9}) {  // of faces turned over
    Model model = test::makeSphere(3);
    uint64_t turned = 0;
    for (size_t f = 0; f < model.faceCount(); ++f)
      if (rng.uniform() < share) std::swap(model.corners[3 * f], model.corners[3 * f + 1]), ++turned;
    const auto made = makeOriginal(model);
    ASSERT_TRUE(made.ok());
    EXPECT_EQ(made->flipped, turned);
    for (const Triangle& t : made->faces) {
      const dvec3 &a = made->positions[t[0]], &b = made->positions[t[1]], &c = made->positions[t[2]];
      EXPECT_GT(glm::dot(glm::cross(b - a, c - a), a), 0);
    }
  }
}

TEST(Original, QuadranglesThatShareTwoEdgesAreCutApart) {
  const auto made = makeOriginal(
      test::makeModel({{0, 0, 0}, {2, 0, 0}, {1, 0.5, 0.1}, {1, 2, 0}, {1, -2, 0}}, {{0, 2, 1, 3}, {0, 4, 1, 2}}));
  ASSERT_TRUE(made.ok()) << made.error().message;
  EXPECT_EQ(made->faces.size(), 4u);
}

// Any polygon that is star-shaped about the origin: areas add up, all triangles face its way.
TEST(Triangulate, CoversThePolygon) {
  constexpr uint64_t kSeed = 3;
  SCOPED_TRACE(kSeed);
  Rng rng(kSeed);
  for (int i = 0; i < 500; ++i) {
    std::vector<dvec3> outline;
    const auto count = 3 + rng.below(12);
    for (uint64_t k = 0; k < count; ++k) {
      const double turn =
          2 * std::numbers::pi * (static_cast<double>(k) + rng.uniform(0.1, 0.9)) / static_cast<double>(count);
      outline.push_back(rng.uniform(0.3, 1) * dvec3(std::cos(turn), std::sin(turn), 0));
    }
    const dvec3 whole = vectorArea(outline);
    if (whole.z <= 0) continue;
    const auto triangles = triangulate(outline, [](uint32_t, uint32_t) { return true; });
    ASSERT_EQ(triangles.size(), count - 2);
    double sum = 0;
    for (const auto& t : triangles) {
      const dvec3 area = vectorArea(std::vector<dvec3>{outline[t[0]], outline[t[1]], outline[t[2]]});
      ASSERT_GT(area.z, 0);
      sum += area.z;
    }
    ASSERT_NEAR(sum, whole.z, 1e-12);
  }
}

}  // namespace
}  // namespace foreland::terrain
