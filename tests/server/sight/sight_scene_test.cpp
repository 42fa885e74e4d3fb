// Lines of sight against a plain walk over triangles (tests/support/sight_reference.h), and against formulas.
#include "server/sight/sight_scene.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <glm/geometric.hpp>

#include "base/rng.h"
#include "server/sight/sight_line.h"
#include "terrain/dem/open.h"
#include "tests/support/data.h"
#include "tests/support/scene.h"
#include "tests/support/seed.h"
#include "tests/support/sight_reference.h"
#include "tests/world/ring_of_objects.h"

namespace foreland::test {
namespace {

using server::Hierarchy;
using server::SightScene;

struct Place {
  std::shared_ptr<const terrain::Scene> scene;
  Hierarchy hierarchy;
  std::shared_ptr<const SightScene> sight;

  Place(std::shared_ptr<const terrain::Scene> of, uint32_t objects = 0)
      : scene(of),
        hierarchy(of, proto::ErrorBound::kSpheroid, objects > 0 ? objectsIn(*of, objects) : server::SceneObjects{}),
        sight(SightScene::create(hierarchy).value()) {}

  // Above the ground, or on it.
  glm::dvec3 anywhere(Rng& rng, const server::SightTime& time) const {
    const proto::GridShape& shape = scene->grid().shape();
    const glm::dvec2 at{rng.uniform(0, shape.samples_x - 1), rng.uniform(0, shape.samples_y - 1)};
    const double above_m = rng.below(3) == 0 ? 0 : std::exp(rng.uniform(-2, 6.5));
    return sight->aboveGround(at, above_m, time).value();
  }
};

class SightLines : public testing::TestWithParam<proto::FrameKind> {};

TEST_P(SightLines, AreThoseOfAWalkOverAllTriangles) {
  const uint64_t seed = randomSeed();
  const Place place(makeScene(38, 29, seed, GetParam()), 6);
  const PlainGround ground(*place.scene);
  const std::vector<Corners> objects = trianglesOf(place.hierarchy.objects());
  const auto all = [&](const glm::dvec3&, const auto& visit) {
    ground.forAll(visit);
    for (const Corners& t : objects) visit(t);
  };
  const server::SightTime time = place.sight->at(std::nullopt);
  Rng rng(seed);
  int hidden = 0, by_objects = 0, grazing = 0;
  for (int i = 0; i < 800; ++i) {
    PlainLine line{ground.transform(), place.anywhere(rng, time), place.anywhere(rng, time), 0.5 * rng.below(3)};
    if (rng.below(2) == 0) {  // through an object
      const Corners& t = objects[rng.below(static_cast<uint32_t>(objects.size()))];
      line.to += 1.3 * ((t[0] + t[1] + t[2]) / 3.0 - line.from) - (line.to - line.from);
    }
    const auto plainly = [&](const PlainLine& l) { return firstHitPlainly(l, 4, all); };
    const auto found = place.sight->firstHit(line.from, line.to, line.refraction, time);
    ASSERT_EQ(place.sight->sees(line.from, line.to, line.refraction, time), !found) << "seed " << seed << " line " << i;
    ASSERT_TRUE(isAsPlainly(found, line, plainly, all, grazing)) << "seed " << seed << " line " << i;
    hidden += found ? 1 : 0;
    by_objects += found && found->object >= 0 ? 1 : 0;
  }
  EXPECT_GT(hidden, 40);
  EXPECT_GT(by_objects, 40);
  EXPECT_LT(grazing, 20);
}

TEST_P(SightLines, OnLatticeLinesLetNothingThroughEdges) {
  const Place place(makeScene(38, 29, 5, GetParam()));
  const PlainGround ground(*place.scene);
  const server::SightTime time = place.sight->at(std::nullopt);
  Rng rng(7);
  for (int i = 0; i < 300; ++i) {  // from under the ground to over it, through samples and along edges
    const glm::dvec2 at(1 + rng.below(36), 1 + rng.below(27));
    const glm::dvec3 from = place.sight->aboveGround(at, -50, time).value(),
                     to = place.sight
                              ->aboveGround(at + glm::dvec2(double(rng.below(3)) - 1, double(rng.below(3)) - 1), 50,
                                            time)
                              .value();
    ASSERT_FALSE(place.sight->sees(from, to, 0, time)) << i;
    ASSERT_FALSE(place.sight->sees(to, from, 0, time)) << i;
  }
}

TEST_P(SightLines, StandOnTheTriangles) {
  const Place place(makeScene(38, 29, 6, GetParam()));
  const PlainGround ground(*place.scene);
  const server::SightTime time = place.sight->at(std::nullopt);
  Rng rng(8);
  for (int i = 0; i < 300; ++i) {
    const double x = rng.uniform(0.01, 36.99), y = rng.uniform(0.01, 27.99);
    const proto::LatticePosition stands =
        ground.transform().toLattice(place.sight->aboveGround({x, y}, 0, time).value());
    ASSERT_NEAR(stands.x, x, 1e-3);
    ASSERT_NEAR(stands.y, y, 1e-3);
    ASSERT_NEAR(stands.height_m, ground.heightAt(stands.x, stands.y).value(), 1e-5);
  }
  EXPECT_FALSE(place.sight->aboveGround({-0.1, 3}, 0, time));
  EXPECT_FALSE(place.sight->aboveGround({3, NAN}, 0, time));
}

TEST_P(SightLines, BetweenTwoPointsOfATriangleAreFree) {
  const Place place(makeScene(38, 29, 9, GetParam()));
  const server::SightTime time = place.sight->at(std::nullopt);
  Rng rng(10);
  for (int i = 0; i < 2000; ++i) {
    const glm::dvec2 cell(rng.below(37), rng.below(28));
    const auto point = [&] {
      const glm::dvec2 within(rng.uniform(0.3, 0.7), rng.uniform(0.02, 0.25));  // below either diagonal
      return place.sight->aboveGround(cell + within, 0, time).value();
    };
    ASSERT_TRUE(place.sight->sees(point(), point(), 1, time)) << i;  // straight on maps, 10^-6 m above it elsewhere
    ASSERT_TRUE(place.sight->sees(point(), point(), GetParam() == proto::FrameKind::kPlanar ? 1 : 0, time)) << i;
  }
}

INSTANTIATE_TEST_SUITE_P(Frames, SightLines, testing::Values(proto::FrameKind::kPlanar, proto::FrameKind::kGeographic));

// An eye h above the sea sees the sea as far as sqrt(2 R h / (1 - k)).
TEST(SightLinesOverTheSea, EndAtTheHorizon) {
  FormulaSource source(2001, 3, [](uint32_t, uint32_t) { return 0.0; });
  source.info().frame.axis_x_m = {30, 0};
  const Place place(makeScene(source));
  const server::SightTime time = place.sight->at(std::nullopt);
  for (const double refraction : {0.0, 1.0 / 7, 0.5}) {
    const double horizon_m = std::sqrt(2 * server::SightLine::kEarthRadius_m * 20 / (1 - refraction));
    const auto sees = [&](double distance_m) {
      const glm::dvec3 eye = place.sight->aboveGround({100, 1}, 20, time).value(),
                       there = place.sight->aboveGround({100 + distance_m / 30, 1}, 0, time).value();
      return place.sight->sees(eye, there, refraction, time);
    };
    EXPECT_TRUE(sees(0.99 * horizon_m)) << refraction;
    EXPECT_FALSE(sees(1.01 * horizon_m)) << refraction;
  }
}

// The same on the ellipsoid, whose ground curves by itself.
TEST(SightLinesOverTheSea, EndAtTheHorizonOfTheEllipsoid) {
  const Place place(makeScene(
      1201, 3, [](uint32_t, uint32_t) { return 0.0; }, proto::FrameKind::kGeographic));
  const server::SightTime time = place.sight->at(std::nullopt);
  const glm::dvec3 eye = place.sight->aboveGround({100, 1}, 20, time).value();
  for (const double refraction : {0.0, 1.0 / 7}) {
    const double horizon_m = std::sqrt(2 * server::SightLine::kEarthRadius_m * 20 / (1 - refraction));
    for (double x = 110; x < 400; ++x) {
      const glm::dvec3 there = place.sight->aboveGround({x, 1}, 0, time).value();
      const double distance_m = glm::distance(eye, there);
      if (std::fabs(distance_m / horizon_m - 1) < 0.02) continue;
      ASSERT_EQ(place.sight->sees(eye, there, refraction, time), distance_m < horizon_m) << x;
    }
  }
}

TEST(SightLinesInTime, AreThoseOfTheGroundOfThatTime) {
  for (const auto blend : {proto::EpochBlend::kLinear, proto::EpochBlend::kCatmullRom, proto::EpochBlend::kBSpline}) {
    const Place place(makeMovingScene(70, 60, 3, 4, proto::FrameKind::kPlanar, blend), 4);
    const proto::Epochs& epochs = place.scene->epochs().epochs();
    Rng rng(11);
    for (int i = 0; i < 200; ++i) {
      const Time when{static_cast<int64_t>(rng.uniform(0, double(epochs.last().us)))};
      const server::SightTime time = place.sight->at(when);
      const proto::GridShape& shape = place.scene->grid().shape();
      const auto x = static_cast<uint32_t>(rng.below(shape.samples_x)),
                 y = static_cast<uint32_t>(rng.below(shape.samples_y));
      // From above a sample to below it: what lies between is the ground of that time.
      const glm::dvec3 there = place.sight->ground().sample(x, y, time.ground), up(0, 0, 1);
      const auto hit = place.sight->firstHit(there + 60.0 * up, there - 60.0 * up, 0, time);
      ASSERT_TRUE(hit) << i;
      if (hit->object == server::SightHit::kGround) { EXPECT_NEAR(hit->position.z, there.z, 1e-6); }
    }
    const server::SightTime last = place.sight->at(std::nullopt), same = place.sight->at(epochs.last());
    EXPECT_EQ(last.ground, same.ground);
  }
}

TEST(SightScenes, AreRefusedWithoutTheMemoryForThem) {
  const auto scene = makeScene(200, 200, 3);
  const Hierarchy hierarchy(scene);
  const auto refused = SightScene::create(hierarchy, {100'000});
  ASSERT_FALSE(refused.ok());
  EXPECT_EQ(refused.error().code, ErrorCode::kLimit);
  const auto made = SightScene::create(hierarchy, {10u << 20});
  ASSERT_TRUE(made.ok());
  EXPECT_LT((*made)->bytes(), 200 * 200 * 40u);
}

// FORELAND_SIGHT_PAIRS=100000 asks for as many.
TEST(SightLinesOverHelens, AreThoseOfAWalkOverAllTriangles) {
  FORELAND_DATA_OR_SKIP(file, "dem/msh/msh_base_utm10_10m.tif");
  const char* wanted = std::getenv("FORELAND_SIGHT_PAIRS");
  const int pairs = wanted != nullptr ? std::atoi(wanted) : 300;
  auto source = terrain::openElevation({file}, {});
  ASSERT_TRUE(source.ok());
  const Place place(makeScene(**source));
  const PlainGround ground(*place.scene);
  const server::SightTime time = place.sight->at(std::nullopt);
  const auto near = [&](const glm::dvec3& middle, const auto& visit) {
    const proto::LatticePosition at = ground.transform().toLattice(middle);
    for (int j = -1; j <= 1; ++j)
      for (int i = -1; i <= 1; ++i)
        ground.forCell(std::llround(std::floor(at.x)) + i, std::llround(std::floor(at.y)) + j, visit);
  };
  const auto plainly = [&](const PlainLine& line) {
    const double cells = glm::distance(glm::dvec2(line.from), glm::dvec2(line.to)) / 10;
    return firstHitPlainly(line, 1 + static_cast<int>(2 * cells), near);
  };
  const uint64_t seed = randomSeed();
  Rng rng(seed);
  int hidden = 0, grazing = 0;
  for (int i = 0; i < pairs; ++i) {
    const PlainLine line{ground.transform(), place.anywhere(rng, time), place.anywhere(rng, time), 1.0 / 7};
    const auto found = place.sight->firstHit(line.from, line.to, line.refraction, time);
    hidden += found ? 1 : 0;
    ASSERT_TRUE(isAsPlainly(found, line, plainly, near, grazing)) << "seed " << seed << " line " << i;
  }
  std::printf("%d pairs: %d hidden, %d within 1 cm of grazing\n", pairs, hidden, grazing);
  EXPECT_GT(hidden, pairs / 10);
  EXPECT_LT(grazing, 1 + pairs / 200);
}

}  // namespace
}  // namespace foreland::test
