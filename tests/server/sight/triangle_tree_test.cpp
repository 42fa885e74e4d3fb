// Lines of sight over small planets against a plain walk over all of their finest triangles, which are found by the
// judge's own faces (oracle/globe/cube_faces.h) and stand where GeographicLib says.
#include "server/sight/triangle_tree.h"

#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>

#include "base/rng.h"
#include "server/sight/sight_scene.h"
#include "server/sight/viewshed.h"
#include "tests/support/globe_scene.h"
#include "tests/support/plain_planet.h"
#include "tests/support/seed.h"
#include "tests/support/sight_reference.h"
#include "tests/world/ring_of_objects.h"

namespace foreland::test {
namespace {

using server::SightScene;

// A planet that is whole, or fine about a corner and a pole alone.
struct Planet {
  std::shared_ptr<const terrain::Scene> scene;
  server::Hierarchy hierarchy;
  std::shared_ptr<const SightScene> sight;
  server::SightTime now;
  PlainPlanet plain;

  Planet(uint64_t seed, uint32_t face_log2, uint32_t sparse_levels, uint32_t objects = 0)
      : scene(makeGlobeScene(face_log2, seed, sparse_levels)),
        hierarchy(scene, proto::ErrorBound::kSpheroid,
                  objects > 0 ? objectsIn(*scene, objects) : server::SceneObjects{}),
        sight(SightScene::create(hierarchy).value()),
        now(sight->at(std::nullopt)),
        plain(*scene) {}

  double side() const { return scene->grid().rootSize(); }
  int64_t cells() const { return scene->grid().rootSize(); }
  // A lattice position, often on an edge of the cube, at a corner or at a pole.
  glm::dvec2 anywhere(Rng& rng) const {
    const auto share = [&] { return rng.below(4) == 0 ? 0.5 * rng.below(3) : rng.uniform(0, 1); };
    return {std::min((rng.below(6) + share()) * side(), 6 * side()), share() * side()};
  }
  // Above the ground, or on it.
  glm::dvec3 above(const glm::dvec2& lattice, Rng& rng) const {
    return sight->aboveGround(lattice, rng.below(3) == 0 ? 0 : std::exp(rng.uniform(-2, 7)), now).value();
  }
  // The same, within view of a point.
  glm::dvec3 near(const glm::dvec3& point, Rng& rng) const {
    const glm::dvec3 aside(rng.uniform(-1, 1), rng.uniform(-1, 1), rng.uniform(-1, 1));
    const proto::LatticePosition at = sight->transform().toLattice(point + 1500.0 * aside);
    return above({at.x, at.y}, rng);
  }
};

class SightLinesOverPlanets : public testing::TestWithParam<uint32_t> {};

TEST_P(SightLinesOverPlanets, AreThoseOfAWalkOverAllTriangles) {
  const uint64_t seed = randomSeed();
  const Planet planet(seed, 4 + GetParam(), GetParam(), 6);
  const std::vector<Corners> objects = trianglesOf(planet.hierarchy.objects());
  const auto all = [&](const glm::dvec3&, const auto& visit) {
    planet.plain.forAll(visit);
    for (const Corners& t : objects) visit(t);
  };
  Rng rng(seed);
  int hidden = 0, seen = 0, by_objects = 0, grazing = 0;
  for (int i = 0; i < 400; ++i) {
    PlainLine line{planet.sight->transform(), planet.above(planet.anywhere(rng), rng), glm::dvec3(0), 0};
    line.to = planet.above(planet.anywhere(rng), rng);
    if (rng.below(4) > 0) {  // light bends by less than a centimetre in a piece of the plain walk
      line.to = planet.near(line.from, rng);
      line.refraction = 0.5 * rng.below(3);
    }
    if (rng.below(8) == 0) {  // down through an object
      const Corners& t = objects[rng.below(static_cast<uint32_t>(objects.size()))];
      const glm::dvec3 middle = (t[0] + t[1] + t[2]) / 3.0;
      line.from = 1.05 * middle + glm::dvec3(rng.uniform(-400, 400), rng.uniform(-400, 400), 0);
      line.to = line.from + 1.3 * (middle - line.from);
    }
    const auto plainly = [&](const PlainLine& l) { return firstHitPlainly(l, 4, all); };
    const auto found = planet.sight->firstHit(line.from, line.to, line.refraction, planet.now);
    ASSERT_EQ(planet.sight->sees(line.from, line.to, line.refraction, planet.now), !found)
        << "seed " << seed << " " << i;
    ASSERT_TRUE(isAsPlainly(found, line, plainly, all, grazing)) << "seed " << seed << " line " << i;
    hidden += found ? 1 : 0;
    seen += found ? 0 : 1;
    by_objects += found && found->object >= 0 ? 1 : 0;
  }
  EXPECT_GT(hidden, 40);
  EXPECT_GT(seen, 40);
  EXPECT_GT(by_objects, 10);
  EXPECT_LT(grazing, 12);
}

// Pixels of the whole planet and of its limb, each a line through all of it, and lines straight down.
TEST_P(SightLinesOverPlanets, FromSpaceMeetWhatAWalkMeets) {
  const Planet planet(3, 4 + GetParam(), GetParam());
  const auto all = [&](const glm::dvec3&, const auto& visit) { planet.plain.forAll(visit); };
  Rng rng(5);
  int hidden = 0, grazing = 0;
  for (int i = 0; i < 150; ++i) {
    const glm::dvec2 below = planet.anywhere(rng);
    const glm::dvec3 eye = planet.sight->onZeroSurface(below, std::exp(rng.uniform(6, 12))).value();
    const glm::dvec3 aim =
        i % 3 == 0 ? glm::dvec3(0)
                   : 21e3 * glm::normalize(glm::dvec3(rng.uniform(-1, 1), rng.uniform(-1, 1), rng.uniform(-1, 1)));
    const PlainLine line{planet.sight->transform(), eye, eye + 2.0 * (aim - eye), 0};
    const auto plainly = [&](const PlainLine& l) { return firstHitPlainly(l, 1, all); };
    const auto found = planet.sight->firstHit(line.from, line.to, 0, planet.now);
    ASSERT_TRUE(isAsPlainly(found, line, plainly, all, grazing)) << i;
    hidden += found ? 1 : 0;
  }
  EXPECT_GT(hidden, 60);
}

// A straight way across edges, corners and poles meets first what the first of its parts meets that meets anything.
TEST_P(SightLinesOverPlanets, AcrossAnEdgeAreTheirPartsTogether) {
  const Planet planet(7, 4 + GetParam(), GetParam());
  Rng rng(9);
  int hidden = 0;
  for (int i = 0; i < 300; ++i) {
    const glm::dvec3 middle = planet.above(planet.anywhere(rng), rng),
                     across =
                         glm::cross(middle, glm::dvec3(rng.uniform(-1, 1), rng.uniform(-1, 1), rng.uniform(-1, 1))),
                     part = rng.uniform(500, 4000) * glm::normalize(across);
    const auto first = [&](const glm::dvec3& from, const glm::dvec3& to) {
      return planet.sight->firstHit(from, to, 0, planet.now);
    };
    const auto whole = first(middle - part, middle + part);
    auto parts = first(middle - part, middle);
    if (!parts) parts = first(middle, middle + part);
    if (whole && glm::distance(whole->position, middle) < 2e-3) continue;  // a part's end, near which nothing hides
    ASSERT_EQ(whole.has_value(), parts.has_value()) << i;
    if (!whole) continue;
    ++hidden;
    ASSERT_LT(glm::distance(whole->position, parts->position), 1e-5) << i;
  }
  EXPECT_GT(hidden, 100);
}

// The same from each of the faces that hold it, and there where the triangles are.
TEST_P(SightLinesOverPlanets, EndOnTheTriangles) {
  const Planet planet(11, 4 + GetParam(), GetParam());
  const double side = planet.side();
  const auto ground = [&](double x, double y) { return planet.sight->aboveGround({x, y}, 0, planet.now).value(); };
  for (uint32_t face = 0; face < 6; ++face)
    for (int64_t y = 0; y <= planet.cells(); ++y)
      for (int64_t x = 0; x < planet.cells(); ++x) {
        if (!planet.plain.isThere(face, {x, y})) continue;
        const glm::dvec2 at(x, y);
        ASSERT_LT(glm::distance(ground(face * side + at.x, at.y),
                                planet.plain.at(face, at, planet.plain.heightMetres(face, {x, y}))),
                  1e-6);
      }
  for (uint32_t face = 1; face < 6; face += 2)  // an odd face's north side is the next one's south side
    for (double x = 0.25; x < side; ++x)
      ASSERT_LT(glm::distance(ground(face * side + x, side), ground((face + 1) % 6 * side + x, 0)), 1e-6);
  for (uint32_t face = 0; face < 6; face += 2)  // an even face's turned, the west side of the next but one
    for (double x = 0.25; x < side; ++x)
      ASSERT_LT(glm::distance(ground(face * side + x, side), ground((face + 2) % 6 * side, side - x)), 1e-6);
  EXPECT_FALSE(planet.sight->aboveGround({6 * side + 0.1, 3}, 0, planet.now));
  EXPECT_FALSE(planet.sight->aboveGround({3, NAN}, 0, planet.now));
  EXPECT_FALSE(planet.sight->onZeroSurface({3, side + 0.1}, 0));
}

TEST_P(SightLinesOverPlanets, BetweenTwoPointsOfATriangleAreFree) {
  const Planet planet(17, 4 + GetParam(), GetParam());
  Rng rng(10);
  for (int i = 0; i < 2000; ++i) {
    const auto cells = static_cast<uint32_t>(planet.cells());
    const glm::dvec2 cell(rng.below(6 * cells), rng.below(cells));
    const auto point = [&] {
      const glm::dvec2 within(rng.uniform(0.3, 0.7), rng.uniform(0.02, 0.25));  // below either diagonal
      return planet.sight->aboveGround(cell + within, 0, planet.now).value();
    };
    ASSERT_TRUE(planet.sight->sees(point(), point(), 0, planet.now)) << i;
  }
}

INSTANTIATE_TEST_SUITE_P(SparseLevels, SightLinesOverPlanets, testing::Values(0u, 2u));

TEST(SightScenesOverPlanets, TakeNoMemoryForTheGround) {
  const Planet planet(13, 5, 0);
  EXPECT_TRUE(SightScene::create(planet.hierarchy, {1 << 16}).ok());
  EXPECT_LT(planet.sight->bytes(), 1u << 14);
}

TEST(ViewshedsOverPlanets, EndWithTheObserversFace) {
  const Planet planet(15, 5, 0);
  const double side = planet.side();
  for (uint32_t face = 0; face < 6; ++face)
    for (const glm::dvec2& at : {glm::dvec2(0, 0), glm::dvec2(side - 1e-9, side), glm::dvec2(5.5, 20)}) {
      const server::ViewshedQuestion question{
          at + glm::dvec2(face * side, 0), 30, 0, 6e3, std::nullopt, 0, std::nullopt};
      const auto grid = server::Viewshed::gridOf(planet.hierarchy, question, 1u << 20);
      ASSERT_TRUE(grid.ok());
      const server::Viewshed viewshed(planet.sight, question, *grid);
      int seen = 0;
      for (uint32_t row = 0; row < grid->rows; ++row)
        for (uint32_t column = 0; column < grid->columns; ++column) {
          const glm::dvec2 middle = grid->middle(column, row);
          ASSERT_GE(middle.x, face * side);
          ASSERT_LT(middle.x, (face + 1) * side);
          const glm::dvec3 foot = planet.plain.at(face, middle - glm::dvec2(face * side, 0), 0),
                           here = planet.plain.at(face, at, 0);
          const bool is_asked = viewshed.cell(column, row) != server::ViewshedCell::kOutside;
          if (std::fabs(glm::distance(foot, here) - 6e3) > 1e-3) {
            ASSERT_EQ(is_asked, glm::distance(foot, here) < 6e3);
          }
          seen += viewshed.cell(column, row) == server::ViewshedCell::kSeen ? 1 : 0;
        }
      EXPECT_GT(seen, 0);
    }
}

}  // namespace
}  // namespace foreland::test
