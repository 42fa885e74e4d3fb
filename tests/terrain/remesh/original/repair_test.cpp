// Repairing a model that is no surface: what holds for any soup of triangles, then what people's models look like.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <glm/geometric.hpp>
#include <set>
#include <tuple>

#include "base/rng.h"
#include "terrain/remesh/original/orientation.h"
#include "terrain/remesh/original/original.h"
#include "tests/support/models.h"
#include "tests/support/seed.h"

namespace foreland::terrain {
namespace {

using glm::dvec3;
using Faces = std::vector<std::vector<uint32_t>>;
using Place = std::tuple<double, double, double>;
using Places = std::array<Place, 3>;

Place placeOf(const dvec3& p) { return {p.x, p.y, p.z}; }

Places placesOf(const std::vector<dvec3>& positions, const Triangle& t) {
  Places places{placeOf(positions[t[0]]), placeOf(positions[t[1]]), placeOf(positions[t[2]])};
  std::sort(places.begin(), places.end());
  return places;
}

bool hasArea(const std::vector<dvec3>& p, const Triangle& t) {
  return glm::length(glm::cross(p[t[1]] - p[t[0]], p[t[2]] - p[t[0]])) > 0;
}

// A repaired surface as a model.
Model modelOf(const Original& original) {
  Faces faces;
  for (const Triangle& t : original.faces) faces.push_back({t[0], t[1], t[2]});
  return test::makeModel(original.positions, faces);
}

// The faces around each vertex form one fan, each edge has at most two faces, and neighbours are turned the same way.
void expectManifold(const Original& made) {
  const Adjacency adjacency = findAdjacency(made.faces);
  ASSERT_EQ(adjacency.non_manifold_face, kNoIndex);
  ASSERT_EQ(made.twins, adjacency.twins);
  std::vector<uint32_t> edges(made.positions.size()), corners(made.positions.size());
  for (uint32_t f = 0; f < made.faces.size(); ++f)
    for (uint32_t k = 0; k < 3; ++k) {
      const uint32_t v = made.faces[f][k], next = made.faces[f][(k + 1) % 3], twin = made.twins[f][k];
      ++corners[v];
      if (twin == kNoIndex || f < twin / 3) ++edges[v], ++edges[next];
      if (twin != kNoIndex) { ASSERT_EQ(made.faces[twin / 3][twin % 3], next) << "neighbours contradict each other"; }
    }
  for (uint32_t v = 0; v < made.positions.size(); ++v) {
    ASSERT_GT(corners[v], 0u);
    ASSERT_LE(edges[v], corners[v] + 1) << "vertex " << v << " has several fans";
  }
}

// A few vertices and many faces on them: everything that can be wrong is.
Model makeSoup(Rng& rng, uint64_t max_corners = 3) {
  std::vector<dvec3> p(4 + rng.below(30));
  const auto side = 2 + rng.below(3);
  for (dvec3& at : p)
    at = {static_cast<double>(rng.below(side)), static_cast<double>(rng.below(side)),
          static_cast<double>(rng.below(side))};
  Faces faces(1 + rng.below(40));
  for (auto& face : faces)
    for (uint64_t count = 3 + rng.below(max_corners - 2); count > 0; --count)
      face.push_back(static_cast<uint32_t>(rng.below(p.size())));
  return test::makeModel(p, faces);
}

TEST(Repair, AnySoupBecomesAManifoldOfTheSameTriangles) {
  const uint64_t seed = test::randomSeed();
  SCOPED_TRACE(seed);
  Rng rng(seed);
  int repaired = 0;
  for (int i = 0; i < 1000; ++i) {
    const Model soup = makeSoup(rng);
    std::set<Places> given;
    for (size_t f = 0; f < soup.faceCount(); ++f) {
      const Triangle t{soup.corners[3 * f].vertex, soup.corners[3 * f + 1].vertex, soup.corners[3 * f + 2].vertex};
      if (hasArea(soup.positions, t)) given.insert(placesOf(soup.positions, t));
    }
    const auto made = makeOriginal(soup, OnDefect::kRepair);
    ASSERT_EQ(made.ok(), !given.empty()) << made.error().message;
    if (!made.ok()) continue;
    expectManifold(*made);
    std::set<Places> kept;
    for (const Triangle& t : made->faces) ASSERT_TRUE(kept.insert(placesOf(made->positions, t)).second);
    ASSERT_EQ(kept, given);
    repaired += made->repairs != Repairs{};
  }
  EXPECT_GT(repaired, 900);
}

TEST(Repair, OfARepairedModelChangesNothing) {
  const uint64_t seed = test::randomSeed();
  SCOPED_TRACE(seed);
  Rng rng(seed);
  int repaired = 0;
  for (int i = 0; i < 2000; ++i) {
    const auto made = makeOriginal(makeSoup(rng, i % 2 == 0 ? 3 : 4), OnDefect::kRepair);
    if (!made.ok()) continue;
    expectManifold(*made);
    repaired += made->repairs != Repairs{};
    const auto again = makeOriginal(modelOf(*made), OnDefect::kRepair);
    ASSERT_TRUE(again.ok());
    ASSERT_EQ(again->repairs, Repairs{});
    ASSERT_EQ(again->welded, 0u);
    ASSERT_EQ(again->flipped, 0u);
    ASSERT_EQ(again->positions, made->positions);
    ASSERT_EQ(again->faces, made->faces);
    ASSERT_EQ(again->twins, made->twins);
  }
  EXPECT_GT(repaired, 900);
}

void expectSame(const Original& a, const Original& b) {
  EXPECT_EQ(a.positions, b.positions);
  EXPECT_EQ(a.faces, b.faces);
  EXPECT_EQ(a.twins, b.twins);
  EXPECT_EQ(a.source_corners, b.source_corners);
  EXPECT_EQ(a.source_vertices, b.source_vertices);
  EXPECT_EQ(a.welded, b.welded);
  EXPECT_EQ(a.flipped, b.flipped);
}

TEST(Repair, ChangesNothingWhereNothingIsWrong) {
  Model turned = test::makeTorus(12, 8);
  for (size_t f = 0; f < turned.faceCount(); f += 5)
    std::reverse(turned.corners.begin() + static_cast<ptrdiff_t>(turned.faceBegin(f)),
                 turned.corners.begin() + static_cast<ptrdiff_t>(turned.face_ends[f]));
  const Model apart =
      test::makeModel({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0, 0, 0}, {-1, 0, 0}, {0, -1, 0}, {0, 0, -1}},
                      {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}, {4, 5, 6}, {4, 7, 5}, {4, 6, 7}, {5, 7, 6}});
  for (const Model& model :
       {test::makeSphere(3), test::makeTorus(20, 10), test::makePatch(9), test::makeCube(4), turned, apart}) {
    const auto made = makeOriginal(model, OnDefect::kRepair);
    ASSERT_TRUE(made.ok());
    EXPECT_EQ(made->repairs, Repairs{});
    expectSame(*made, *makeOriginal(model, OnDefect::kRefuse));
  }
}

const std::vector<dvec3> kSquare{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0, 0, 1}};

Repairs repairsOf(const Model& model) {
  const auto made = makeOriginal(model, OnDefect::kRepair);
  EXPECT_TRUE(made.ok()) << made.error().message;
  if (!made.ok()) return {};
  expectManifold(*made);
  return made->repairs;
}

TEST(Repair, CountsWhatItDoes) {
  EXPECT_EQ(repairsOf(test::makeModel(kSquare, {{0, 1, 2}, {0, 2, 1}})), (Repairs{.duplicate_faces = 1}));
  EXPECT_EQ(repairsOf(test::makeModel(kSquare, {{0, 1, 2, 3}, {2, 1, 0, 3}})), (Repairs{.duplicate_faces = 1}));
  EXPECT_EQ(repairsOf(test::makeModel(kSquare, {{0, 1, 2}, {0, 3, 3}})), (Repairs{.degenerate_faces = 1}));
  EXPECT_EQ(repairsOf(test::makeModel(kSquare, {{0, 1, 1, 2, 3}})), (Repairs{.repeated_corners = 1}));
  EXPECT_EQ(repairsOf(test::makeModel(kSquare, {{0, 1, 4, 1, 2, 3}})), (Repairs{.repeated_corners = 2}));
  // Three sheets at one edge, and a sheet that only touches another's edge in space.
  EXPECT_EQ(repairsOf(test::makeModel(kSquare, {{0, 1, 2}, {1, 0, 3}, {0, 1, 4}})),
            (Repairs{.cut_edges = 1, .split_vertices = 4}));
  EXPECT_EQ(repairsOf(test::makeModel({{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0, 0, 0}, {1, 0, 0}, {0, 0, 1}},
                                      {{0, 1, 2}, {1, 0, 3}, {4, 5, 6}})),
            Repairs{});
  // Two tetrahedra that share a vertex.
  EXPECT_EQ(repairsOf(test::makeModel(
                {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {-1, 0, 0}, {0, -1, 0}, {0, 0, -1}},
                {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}, {0, 4, 5}, {0, 6, 4}, {0, 5, 6}, {4, 6, 5}})),
            (Repairs{.split_vertices = 1}));
}

TEST(Repair, CutsAOneSidedSurfaceOnce) {
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
  EXPECT_EQ(repairsOf(test::makeModel(p, faces)), (Repairs{.cut_edges = 1, .split_vertices = 2}));
}

TEST(Repair, RefusesWhatIsNotSafe) {
  const auto words = [](const Model& model) {
    const auto made = makeOriginal(model, OnDefect::kRepair);
    return made.ok() ? std::string() : made.error().message;
  };
  EXPECT_NE(words(test::makeModel(kSquare, {{0, 2, 1, 3}})).find("crosses itself"), std::string::npos);
  EXPECT_NE(words(test::makeModel(kSquare, {{0, 1, 1}, {0, 1, 0}})).find("no face with an area"), std::string::npos);
  EXPECT_NE(words(test::makeModel({{0, 0, 0}, {1e-12, 0, 0}, {0, 1e-12, 0}}, {{0, 1, 2}})).find("smaller than 1e-9"),
            std::string::npos);
}

TEST(Repair, RemembersTheOrientationAndTheLinesOfTheFile) {
  Model model = test::makeSphere(2);
  for (size_t f = 0; f < model.faceCount(); f += 3) std::swap(model.corners[3 * f], model.corners[3 * f + 1]);
  const auto made = makeOriginal(model, OnDefect::kRepair);
  ASSERT_TRUE(made.ok());
  const std::vector<Triangle> given = facesAsGiven(*made);
  for (size_t f = 0; f < given.size(); ++f) EXPECT_EQ(given[f] != made->faces[f], f % 3 == 0) << f;
  const auto lined = makeOriginal(test::makeModel(kSquare, {{0, 1, 2}, {0, 4, 4}}), OnDefect::kRepair);
  ASSERT_TRUE(lined.ok());
  EXPECT_EQ(lined->degenerate.front(), (Triangle{0, 4, 4}));
}

}  // namespace
}  // namespace foreland::terrain
