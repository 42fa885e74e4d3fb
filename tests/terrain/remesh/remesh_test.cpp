// Laws of the remesh: topology stays, borders and creases stay, vertices lie on the original, nothing folds.
#include "terrain/remesh/remesh.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <set>

#include "base/rng.h"
#include "terrain/compare/deviation.h"
#include "terrain/remesh/original/triangulate.h"
#include "terrain/remesh/simplify/simplify.h"
#include "tests/support/models.h"

namespace foreland::terrain {
namespace {

using glm::dvec3;

Original original(const Model& model) {
  auto made = makeOriginal(model);
  EXPECT_TRUE(made.ok()) << made.error().message;
  return std::move(made).value();
}

// Vertices - edges + faces, and the number of border edges, counted by pairs of vertices.
struct Census {
  int64_t euler = 0, border = 0, crowded = 0;
  bool operator==(const Census&) const = default;
};
Census census(size_t vertices, const std::vector<Triangle>& faces) {
  std::map<std::pair<uint32_t, uint32_t>, int> edges;
  for (const Triangle& t : faces)
    for (uint32_t k = 0; k < 3; ++k) ++edges[std::minmax(t[k], t[(k + 1) % 3])];
  Census count{static_cast<int64_t>(vertices) - static_cast<int64_t>(edges.size()) +
               static_cast<int64_t>(faces.size())};
  for (const auto& [edge, uses] : edges) count.border += uses == 1, count.crowded += uses > 2;
  return count;
}

double diagonal(const std::vector<dvec3>& positions) {
  dvec3 low = positions.front(), high = low;
  for (const dvec3& p : positions) low = glm::min(low, p), high = glm::max(high, p);
  return glm::length(high - low);
}

constexpr double kTolerance = 5e-4;  // of the diagonal

struct Judged {
  double hausdorff = 0;  // as a share of the diagonal; an upper bound
  size_t flipped = 0;
};
Judged judge(const Original& surface, const Remeshed& made) {
  const auto triangles = made.lattice.triangles();
  const MeshView of{surface.positions, surface.faces}, by{made.positions, triangles};
  const double size = diagonal(surface.positions);
  const ClosestPoint to_original(of), to_remesh(by);
  const double far = std::max(largestDistance(by, to_original, kTolerance * size, 0),
                              largestDistance(of, to_remesh, kTolerance * size, 0));
  return {far / size + kTolerance, findFlipped(by, to_original, 0).size()};
}

TEST(Remesh, KeepsTheTopology) {
  const struct {
    Model model;
    uint32_t base;
    Census expected;
  } cases[] = {{test::makeSphere(4), 60, {2, 0, 0}},
               {test::makeTorus(40, 20), 80, {0, 0, 0}},
               {test::makeCube(6), 60, {2, 0, 0}}};
  for (const auto& c : cases) {
    const Original surface = original(c.model);
    const auto made = remesh(surface, {.base_triangles = c.base, .levels = 3, .attempts = 2});
    ASSERT_TRUE(made.ok());
    EXPECT_LE(made->base_faces.size(), c.base);
    EXPECT_EQ(census(made->base_vertices.size(), made->base_faces), c.expected);
    EXPECT_EQ(census(made->positions.size(), made->lattice.triangles()), c.expected);
  }
}

TEST(Remesh, BorderStaysBorder) {
  const Original surface = original(test::makePatch(24));
  const auto made = remesh(surface, {.base_triangles = 40, .levels = 3, .attempts = 2});
  ASSERT_TRUE(made.ok());
  EXPECT_EQ(census(made->positions.size(), made->lattice.triangles()).euler, 1);
  std::set<uint32_t> on_border;
  const Lattice& lattice = made->lattice;
  for (uint32_t e = 0; e < lattice.edgeCount(); ++e)
    for (uint32_t step = 0; lattice.edge(e).is_border && step <= lattice.side(); ++step)
      on_border.insert(lattice.edgeVertex(e, step));
  for (uint32_t v = 0; v < made->positions.size(); ++v) {
    const dvec3& p = made->positions[v];
    const double inside = std::min({p.x, 1 - p.x, p.y, 1 - p.y});
    if (on_border.contains(v))
      EXPECT_LT(std::fabs(inside), 1e-12);
    else
      EXPECT_GT(inside, 0);
  }
  // The corners of the square are corners of the base.
  for (const dvec3& corner : {surface.positions[0], surface.positions[24]})
    EXPECT_NE(std::find(made->base_vertices.begin(), made->base_vertices.end(), corner), made->base_vertices.end());
}

TEST(Remesh, BaseVerticesAreVerticesOfTheOriginalAndStandFirst) {
  const Original surface = original(test::makeTorus(30, 16));
  const auto made = remesh(surface, {.base_triangles = 80, .levels = 2, .attempts = 1});
  ASSERT_TRUE(made.ok());
  const std::set<std::array<double, 3>> known = [&] {
    std::set<std::array<double, 3>> all;
    for (const dvec3& p : surface.positions) all.insert({p.x, p.y, p.z});
    return all;
  }();
  for (uint32_t v = 0; v < made->base_vertices.size(); ++v) {
    EXPECT_EQ(made->positions[v], made->base_vertices[v]);
    EXPECT_TRUE(known.contains({made->positions[v].x, made->positions[v].y, made->positions[v].z}));
  }
  for (uint32_t v = 0; v < made->positions.size(); ++v)
    EXPECT_EQ(made->positions[v], positionOf(made->points[v], surface.positions, surface.faces));
}

TEST(Remesh, SpheresAndToriComeCloseWithoutFolds) {
  const Original sphere = original(test::makeSphere(4)), torus = original(test::makeTorus(48, 24));
  for (const Original* surface : {&sphere, &torus}) {
    const auto made = remesh(*surface, {.base_triangles = 80, .levels = 3, .attempts = 3});
    ASSERT_TRUE(made.ok());
    const Judged judged = judge(*surface, *made);
    EXPECT_LT(judged.hausdorff, 0.005);
    EXPECT_EQ(judged.flipped, 0u);
  }
}

// A triangle across an edge of the cube would cut it by a good part of its own size, about 1/8.
TEST(Remesh, SharpEdgesStaySharp) {
  const Original cube = original(test::makeCube(6));
  const auto made = remesh(cube, {.base_triangles = 24, .levels = 3, .attempts = 1});
  ASSERT_TRUE(made.ok());
  const Judged judged = judge(cube, *made);
  EXPECT_LT(judged.hausdorff, 1.1e-3);
  EXPECT_EQ(judged.flipped, 0u);
}

// With so few base triangles no base edge can follow the ridge: lattice vertices must.
TEST(Remesh, RidgesBetweenBaseEdgesAreFollowed) {
  const Original ridge = original(test::makeGrid(24, 24, {false, false}, [](double u, double v) {
    return dvec3(u, v, 0.5 - std::fabs(u - 0.5 - 0.1 * std::sin(6 * v)));
  }));
  const auto made = remesh(ridge, {.base_triangles = 6, .levels = 4, .attempts = 3});
  ASSERT_TRUE(made.ok());
  EXPECT_LT(judge(ridge, *made).hausdorff, 0.01);
  EXPECT_EQ(judge(ridge, *made).flipped, 0u);
}

TEST(Remesh, IsTheSameForAnyNumberOfThreads) {
  const Original surface = original(test::makeTorus(40, 20));
  const auto one = remesh(surface, {.base_triangles = 60, .levels = 3, .attempts = 3, .threads = 1});
  for (unsigned threads : {2u, 5u}) {
    const auto several = remesh(surface, {.base_triangles = 60, .levels = 3, .attempts = 3, .threads = threads});
    ASSERT_TRUE(one.ok() && several.ok());
    EXPECT_EQ(one->base_faces, several->base_faces);
    EXPECT_EQ(one->positions, several->positions);
  }
}

TEST(Remesh, LevelsBeyondTheLimitAreRefused) {
  const Original surface = original(test::makeSphere(4));
  const auto made = remesh(surface, {.base_triangles = 500, .levels = 12});
  ASSERT_FALSE(made.ok());
  EXPECT_EQ(made.error().code, ErrorCode::kLimit);
}

TEST(CoarseMap, ForthUndoesBack) {
  constexpr uint64_t kSeed = 11;
  SCOPED_TRACE(kSeed);
  Rng rng(kSeed);
  const Original surface = original(test::makeTorus(40, 20));
  const Base base = simplify(surface, {.target_faces = 60});
  for (int i = 0; i < 20000; ++i) {
    dvec3 weights(rng.uniform(), rng.uniform(), rng.uniform());
    weights /= weights.x + weights.y + weights.z;
    const SurfacePoint at{base.map_faces[rng.below(base.map_faces.size())], weights};
    const SurfacePoint back = base.map.toCoarse(base.map.toOriginal(at));
    ASSERT_EQ(back.face, at.face);
    ASSERT_LT(glm::length(back.weights - at.weights), 1e-9);
  }
}

TEST(Lattice, NumbersEachVertexOnce) {
  for (int levels : {0, 1, 2, 5}) {
    const Original surface = original(test::makeTorus(5, 4));
    const Lattice lattice(surface.faces, static_cast<uint32_t>(surface.positions.size()), levels);
    const auto triangles = lattice.triangles();
    EXPECT_EQ(triangles.size(), lattice.triangleCount());
    std::set<uint32_t> seen;
    for (const Triangle& t : triangles) seen.insert(t.begin(), t.end());
    EXPECT_EQ(seen.size(), lattice.vertexCount());
    EXPECT_EQ(*seen.rbegin() + 1, lattice.vertexCount());
    EXPECT_EQ(census(lattice.vertexCount(), triangles), (Census{0, 0, 0}));
  }
}

}  // namespace
}  // namespace foreland::terrain
