// The closed forms of proto/space/frame.h against GeographicLib: 1 mm over scenes anywhere, at the poles and across the
// date line.
#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>

#include "base/rng.h"
#include "proto/space/frame.h"
#include "terrain/geo/geodesy.h"
#include "tests/support/seed.h"

namespace foreland::terrain {
namespace {

constexpr double kDegree = std::numbers::pi / 180;
constexpr double kGuaranteed_m = 1e-3;

proto::Frame geographicFrame(double south_deg, double west_deg, double step_deg, int samples) {
  proto::Frame frame;
  frame.kind = proto::FrameKind::kGeographic;
  frame.latitude0_rad = south_deg * kDegree;
  frame.longitude0_rad = west_deg * kDegree;
  frame.latitude_step_rad = frame.longitude_step_rad = step_deg * kDegree;
  frame.origin = {frame.latitude0_rad + samples / 2 * frame.latitude_step_rad,
                  frame.longitude0_rad + samples / 2 * frame.longitude_step_rad, 0};
  return frame;
}

// Largest distance to GeographicLib, there and back, over random positions in the scene.
double worstError_m(const proto::Frame& frame, int samples, Rng& rng) {
  const proto::FrameTransform transform(frame);
  double worst = 0;
  for (int i = 0; i < 500; ++i) {
    const proto::LatticePosition at{rng.uniform(0, samples - 1), rng.uniform(0, samples - 1),
                                    rng.uniform(-11000, 9000)};
    const proto::Geodetic place{frame.latitude0_rad + at.y * frame.latitude_step_rad,
                                frame.longitude0_rad + at.x * frame.longitude_step_rad, at.height_m};
    const glm::dvec3 reference = referenceToScene(frame, place);
    worst = std::max(worst, glm::distance(transform.toScene(at), reference));
    worst = std::max(worst, glm::distance(transform.toScene(transform.toLattice(reference)), reference));
    worst = std::max(worst, glm::distance(referenceToScene(frame, transform.toGeodetic(reference)), reference));
    worst = std::max(worst, glm::distance(transform.toScene(referenceToGeodetic(frame, reference)), reference));
  }
  return worst;
}

TEST(GeoFrame, AgreesWithGeographicLibOverAnSrtmTile) {
  Rng rng(test::randomSeed());
  EXPECT_LT(worstError_m(geographicFrame(46, 8, 1.0 / 1200, 1201), 1201, rng), kGuaranteed_m);
}

TEST(GeoFrame, AgreesWithGeographicLibOverTheWholeGlobe) {
  Rng rng(test::randomSeed());
  EXPECT_LT(worstError_m(geographicFrame(-89.9, -180, 1.0 / 3, 540), 540, rng), kGuaranteed_m);
}

TEST(GeoFrame, AgreesWithGeographicLibAtThePoles) {
  Rng rng(test::randomSeed());
  EXPECT_LT(worstError_m(geographicFrame(88, 10, 1.0 / 600, 1201), 1201, rng), kGuaranteed_m);
  EXPECT_LT(worstError_m(geographicFrame(-90, 10, 1.0 / 600, 1201), 1201, rng), kGuaranteed_m);
}

TEST(GeoFrame, AgreesWithGeographicLibAcrossTheDateLine) {
  Rng rng(test::randomSeed());
  EXPECT_LT(worstError_m(geographicFrame(-17, 179.5, 1.0 / 1200, 1201), 1201, rng), kGuaranteed_m);
}

TEST(GeoFrame, AgreesWithGeographicLibAnywhere) {
  Rng rng(test::randomSeed());
  for (int i = 0; i < 40; ++i) {
    const proto::Frame frame =
        geographicFrame(rng.uniform(-89, 85), rng.uniform(-180, 180), rng.uniform(1e-5, 4e-3), 1001);
    EXPECT_LT(worstError_m(frame, 1001, rng), kGuaranteed_m)
        << "south-west corner " << frame.latitude0_rad / kDegree << ", " << frame.longitude0_rad / kDegree;
  }
}

TEST(GeoFrame, AgreesWithGeographicLibOnMars) {
  Rng rng(test::randomSeed());
  proto::Frame frame = geographicFrame(-5, 137, 1.0 / 256, 513);
  frame.semi_major_m = 3396190;
  frame.flattening = 0;
  EXPECT_LT(worstError_m(frame, 513, rng), kGuaranteed_m);
}

TEST(GeoFrame, LatticePositionsSurviveTheRoundTrip) {
  Rng rng(test::randomSeed());
  const proto::FrameTransform transform(geographicFrame(46, 8, 1.0 / 1200, 1201));
  for (int i = 0; i < 1000; ++i) {
    const proto::LatticePosition at{rng.uniform(0, 1200), rng.uniform(0, 1200), rng.uniform(-100, 9000)};
    const proto::LatticePosition back = transform.toLattice(transform.toScene(at));
    EXPECT_NEAR(back.x, at.x, 1e-7);
    EXPECT_NEAR(back.y, at.y, 1e-7);
    EXPECT_NEAR(back.height_m, at.height_m, 1e-6);
  }
}

TEST(GeoFrame, SpacingIsTheDistanceBetweenNeighbours) {
  const proto::Frame frame = geographicFrame(46, 8, 1.0 / 1200, 1201);
  const proto::FrameTransform transform(frame);
  const glm::dvec3 here = transform.toScene(proto::LatticePosition{600.5, 600.5, 0});
  const glm::dvec2 spacing_m = sampleSpacing(frame, 1201, 1201);
  EXPECT_NEAR(spacing_m.x, glm::distance(here, transform.toScene(proto::LatticePosition{601.5, 600.5, 0})), 1e-3);
  EXPECT_NEAR(spacing_m.y, glm::distance(here, transform.toScene(proto::LatticePosition{600.5, 601.5, 0})), 1e-3);
}

}  // namespace
}  // namespace foreland::terrain
