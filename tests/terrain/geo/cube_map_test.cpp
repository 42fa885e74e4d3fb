// The globe's positions (proto/space/cube_map.h) against GeographicLib, at random points of the earth, Mars and the
// moon.
#include "proto/space/cube_map.h"

#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>

#include "base/rng.h"
#include "terrain/geo/geodesy.h"
#include "tests/support/seed.h"

namespace foreland::terrain {
namespace {

using proto::CubePoint;
using proto::Spheroid;

constexpr double kGuaranteed_m = 1e-6;

proto::Geodetic geodetic(const glm::dvec3& normal, double height_m) {
  return {std::atan2(normal.z, std::hypot(normal.x, normal.y)), std::atan2(normal.y, normal.x), height_m};
}

// The largest distances from the reference: there, and back by place().
struct Worst {
  double there = 0, back = 0;
};
Worst worstOver(const Ellipsoid& body, int points, Rng& rng) {
  const Spheroid spheroid(body.semi_major_m, body.semi_major_m * (1 - body.flattening));
  Worst worst;
  for (int i = 0; i < points; ++i) {
    const CubePoint at{static_cast<uint32_t>(rng.below(6)), rng.uniform(-1, 1), rng.uniform(-1, 1)};
    const glm::dvec3 vector = proto::cubeVector(at);
    const double height_m = rng.uniform(-11000, 9000);
    const glm::dvec3 p = spheroid.position(vector, height_m);
    worst.there = std::max(worst.there, glm::distance(p, referencePosition(body, geodetic(vector, height_m))));
    const Spheroid::Place place = spheroid.place(p);
    worst.back = std::max({worst.back, std::fabs(place.height_m - height_m),
                           glm::distance(place.normal, glm::normalize(vector)) * body.semi_major_m});
  }
  return worst;
}

TEST(GeoCubeMap, AMillionPointsAgreeWithGeographicLib) {
  Rng rng(test::randomSeed());
  const Worst worst = worstOver({}, 1'000'000, rng);
  EXPECT_LT(worst.there, kGuaranteed_m);
  EXPECT_LT(worst.back, kGuaranteed_m);
}

TEST(GeoCubeMap, OtherBodiesAgreeWithGeographicLib) {
  Rng rng(test::randomSeed());
  for (const Ellipsoid& body : {Ellipsoid{3396190, 1 / 169.894447223612}, Ellipsoid{1737400, 0}}) {
    const Worst worst = worstOver(body, 100'000, rng);
    EXPECT_LT(worst.there, kGuaranteed_m);
    EXPECT_LT(worst.back, kGuaranteed_m);
  }
}

TEST(GeoCubeMap, PlacesFarAboveAgreeWithGeographicLib) {
  Rng rng(test::randomSeed());
  const Spheroid earth(6378137, 6378137 * (1 - 1 / 298.257223563));
  for (int i = 0; i < 100'000; ++i) {
    const glm::dvec3 vector =
        proto::cubeVector({static_cast<uint32_t>(rng.below(6)), rng.uniform(-1, 1), rng.uniform(-1, 1)});
    const double height_m = std::exp(rng.uniform(0, 19));
    const glm::dvec3 p = referencePosition({}, geodetic(vector, height_m));
    const Spheroid::Place place = earth.place(p);
    ASSERT_NEAR(place.height_m, height_m, 1e-6 + 1e-12 * height_m);
    ASSERT_LT(glm::distance(place.normal, glm::normalize(vector)) * 6378137, 1e-6 + 1e-12 * height_m);
  }
}

}  // namespace
}  // namespace foreland::terrain
