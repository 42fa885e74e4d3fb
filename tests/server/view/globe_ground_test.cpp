// Heights of a globe's ground by latitude and longitude: between the samples that the judge's own faces
// (oracle/globe/cube_faces.h) name, at places that GeographicLib puts into space.
#include <gtest/gtest.h>

#include <cmath>

#include "base/rng.h"
#include "oracle/globe/cube_faces.h"
#include "server/view/ground.h"
#include "terrain/geo/geodesy.h"
#include "tests/support/globe_scene.h"
#include "tests/support/seed.h"

namespace foreland::test {
namespace {

using Place = glm::vec<2, int64_t>;

struct Planet {
  std::shared_ptr<const terrain::Scene> scene = makeGlobeScene(5, 21);
  oracle::CubeFaces cube{5};
  proto::FrameTransform transform{scene->frame()};

  // As a viewer asks, of a place of the earth.
  double asked(proto::Geodetic at) const {
    at.height_m = 0;
    const terrain::Ellipsoid ellipsoid{scene->frame().semi_major_m, scene->frame().flattening};
    const proto::LatticePosition p = transform.toLattice(terrain::referencePosition(ellipsoid, at));
    return server::groundHeight(*scene, p.x, p.y).value();
  }
  // Bilinear on a face.
  double expected(uint32_t face, const glm::dvec2& place) const {
    const Place low(std::min<int64_t>(static_cast<int64_t>(place.x), cube.side() - 1),
                    std::min<int64_t>(static_cast<int64_t>(place.y), cube.side() - 1));
    const glm::dvec2 t = place - glm::dvec2(low);
    const auto height = [&](int64_t x, int64_t y) {
      return scene->height(cube.nameOf(cube.pointOn(face, low + Place(x, y)))) * scene->frame().height_quantum_m;
    };
    return (1 - t.y) * ((1 - t.x) * height(0, 0) + t.x * height(1, 0)) +
           t.y * ((1 - t.x) * height(0, 1) + t.x * height(1, 1));
  }
};

TEST(GlobeGround, LiesBetweenTheSamplesAroundOnAllFaces) {
  const Planet planet;
  const auto side = static_cast<double>(planet.cube.side());
  const uint64_t seed = randomSeed();
  Rng rng(seed);
  for (int i = 0; i < 20'000; ++i) {
    // Every third coordinate on a side, at a corner or in the middle, where poles are.
    const auto share = [&] { return rng.below(3) == 0 ? 0.5 * rng.below(3) : rng.uniform(0, 1); };
    const uint32_t face = rng.below(6);
    const glm::dvec2 place = side * glm::dvec2(share(), share());
    ASSERT_NEAR(planet.asked(planet.cube.geodetic(face, place)), planet.expected(face, place), 1e-5)
        << "seed " << seed << ", face " << face << " at " << place.x << ", " << place.y;
  }
}

// Edges are where the meridians of 45 degrees are, and corners on them; the poles and the antimeridian by all their
// names.
TEST(GlobeGround, IsTheSameByAllNamesOfAPlace) {
  const Planet planet;
  constexpr double kDegree = 0.017453292519943295;
  const auto at = [&](double latitude, double longitude) {
    return planet.asked({latitude * kDegree, longitude * kDegree, 0});
  };
  for (double longitude = -180; longitude <= 180; longitude += 15) {
    EXPECT_NEAR(at(90, longitude), at(90, 0), 1e-5);
    EXPECT_NEAR(at(-90, longitude), at(-90, 0), 1e-5);
  }
  for (double latitude = -90; latitude <= 90; latitude += 7.5) {
    EXPECT_NEAR(at(latitude, 180), at(latitude, -180), 1e-5) << latitude;
    for (double longitude = -180; longitude <= 180; longitude += 45) {
      constexpr double kNear = 1e-8;  // 3 micrometres; slopes are less than 1
      const double here = at(latitude, longitude);
      EXPECT_NEAR(here, at(latitude, longitude + kNear), 1e-4) << latitude << ", " << longitude;
      EXPECT_NEAR(here, at(latitude, longitude - kNear), 1e-4) << latitude << ", " << longitude;
    }
  }
  EXPECT_NEAR(at(-45, 180), at(-45 + 1e-8, 180), 1e-4);  // of which face 4's west side once answered
}

}  // namespace
}  // namespace foreland::test
