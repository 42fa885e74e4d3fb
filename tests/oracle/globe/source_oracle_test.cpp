// The judge of globes against their files finds nothing where samples lie as far off the ground as the scene states,
// and what was done to what is drawn, or to a sample.
#include "oracle/globe/source_oracle.h"

#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>

#include "oracle/globe/cube_faces.h"
#include "terrain/geo/geodesy.h"
#include "tests/oracle/globe/whole_globe.h"
#include "tests/support/globe_scene.h"
#include "tests/support/seed.h"

namespace foreland::oracle {
namespace {

constexpr uint32_t kSourceLog2 = 5, kSourceSide = 1u << kSourceLog2;
constexpr double kResidual_m = 12;
const proto::Lens kSourceLens{.vertical_fov_rad = 1.2, .width_px = 800, .height_px = 800};

std::shared_ptr<const terrain::Scene> statedScene(uint64_t seed) {
  return test::makeGlobeScene(kSourceLog2, seed, 0,
                              {{.name = "base", .vertical = {}, .window = {}, .residual_m = kResidual_m}});
}

terrain::Ellipsoid ellipsoidOf(const terrain::Scene& scene) {
  return {scene.frame().semi_major_m, scene.frame().flattening};
}

// Samples above and below random points of a mesh's triangles by at most the residual: where these points are, not
// where their places on the cube are.
std::vector<SourceBlock> samplesOn(const terrain::Scene& scene, const client::KeyframeMesh& mesh, Rng& rng) {
  std::vector<SourceBlock> out;
  for (size_t t = 0; t < mesh.indices.size(); t += 3) {
    double a = rng.uniform(0, 1), b = rng.uniform(0, 1);
    if (a + b > 1) a = 1 - a, b = 1 - b;
    const auto corner = [&](size_t k) { return glm::dvec3(mesh.from_positions[mesh.indices[t + k]]); };
    const glm::dvec3 point = a * corner(0) + b * corner(1) + (1 - a - b) * corner(2);
    proto::Geodetic at = terrain::referencePlace(ellipsoidOf(scene), point);
    at.height_m += rng.uniform(-kResidual_m, kResidual_m);
    out.push_back({0, {at}});
  }
  return out;
}

TEST(CubeFaces, FindTheFaceAndPlaceOfAnyDirection) {
  const uint64_t seed = test::randomSeed();
  Rng rng(seed);
  const CubeFaces faces(20);
  for (int i = 0; i < 100'000; ++i) {
    const glm::dvec3 d = glm::normalize(glm::dvec3(rng.uniform(-1, 1), rng.uniform(-1, 1), rng.uniform(-1, 1)));
    const CubeFaces::FacePlace found = faces.placeOf(d);
    const proto::Geodetic at = faces.geodetic(found.face, found.place);
    const glm::dvec3 back(std::cos(at.latitude_rad) * std::cos(at.longitude_rad),
                          std::cos(at.latitude_rad) * std::sin(at.longitude_rad), std::sin(at.latitude_rad));
    ASSERT_LT(glm::distance(back, d), 1e-14) << "seed " << seed;
  }
}

TEST(SourceOracle, FindsNoMoreThanTheResidualOnAGlobeAtFullResolution) {
  const uint64_t seed = test::randomSeed();
  Rng rng(seed);
  const auto scene = statedScene(seed);
  const client::KeyframeMesh mesh = wholeGlobe(*scene, kSourceSide);
  const SourceOracle oracle(*scene, samplesOn(*scene, mesh, rng));
  for (const glm::dvec3& d :
       {glm::dvec3(1, 1, 1), glm::dvec3(0, 0, 1), glm::dvec3(-1, 0.01, 0), glm::dvec3(1, -1, 0.2)}) {
    proto::Pose eye = viewFrom(d, rng.uniform(3'000, 60'000));
    eye.orientation *= glm::angleAxis(rng.uniform(0, 0.4), glm::dvec3(1, 0, 0));
    const SourceDeviation found = oracle.error(mesh, 0.5, eye, kSourceLens, {});
    EXPECT_LE(found.excess_px, 0) << "seed " << seed;
    EXPECT_GT(found.max_px, 0);
    EXPECT_EQ(found.uncovered, 0u) << "seed " << seed;
    EXPECT_GT(found.samples, 20u);
  }
}

TEST(SourceOracle, MeasuresWhatIsOffMoreThanTheResidual) {
  const uint64_t seed = test::randomSeed();
  const auto scene = statedScene(seed);
  client::KeyframeMesh mesh = wholeGlobe(*scene, kSourceSide);
  // One sample far above the middle of a face, seen from aside.
  const proto::Geodetic foot{0.0075, 0.0075, 0};
  const double high_m = 2'000, away_m = 4'000, ground_m = 450;  // at most
  const SourceOracle near(*scene, {{0, {{foot.latitude_rad, foot.longitude_rad, high_m}}}});
  const glm::dvec3 at = terrain::referencePosition(ellipsoidOf(*scene), {foot.latitude_rad, foot.longitude_rad, 1'000});
  const proto::Pose eye{at + glm::dvec3(0, away_m, 0), proto::lookAlong({0, -1, 0}, {1, 0, 0})};
  const SourceDeviation found = near.error(mesh, 0, eye, kSourceLens, {});
  ASSERT_EQ(found.samples, 1u);
  const double px_per_m = kSourceLens.focalPx() / away_m;
  EXPECT_GT(found.max_px, 0.9 * (high_m - ground_m) * px_per_m) << "seed " << seed;
  EXPECT_LT(found.excess_px, found.max_px - kResidual_m * px_per_m);
  EXPECT_GT(found.excess_px, found.max_px - 200 * px_per_m);
  // Nobody sees it through the body.
  const SourceDeviation behind = near.error(mesh, 0, viewFrom({-1, 0, 0}, 40'000), kSourceLens, {});
  EXPECT_EQ(behind.samples, 0u);
  // Where nothing is drawn it is not covered.
  mesh.indices.clear();
  EXPECT_EQ(near.error(mesh, 0, eye, kSourceLens, {}).uncovered, 1u);
}

// A raster along meridians and parallels, degrees.
SourceRaster rasterOf(uint32_t input, uint32_t width, uint32_t height, glm::dvec2 first, double step) {
  SourceRaster raster{input, width, height, {}, {}};
  for (uint32_t y = 0; y < height; ++y)
    for (uint32_t x = 0; x < width; ++x) {
      raster.degrees.push_back(first + step * glm::dvec2(x, y));
      raster.metres.push_back(1);
    }
  return raster;
}

void punch(SourceRaster& raster, uint32_t from, uint32_t to) {
  for (uint32_t y = from; y <= to; ++y)
    for (uint32_t x = from; x <= to; ++x) raster.metres[size_t{y} * raster.width + x] = std::nan("");
}

TEST(SourceSamples, AreThoseWhereTheirFileAloneCounts) {
  constexpr double kRadian = 0.017453292519943295, kFeather_m = 300;
  const auto scene = test::makeGlobeScene(7, test::randomSeed(), 0,
                                          {{.name = "inset",
                                            .vertical = {},
                                            .window = {},
                                            .may_have_voids = true,
                                            .residual_m = 5,
                                            .feather_m = kFeather_m},
                                           {.name = "base", .vertical = {}, .window = {}, .residual_m = 10}});
  SourceRaster inset = rasterOf(0, 81, 81, {10, 0}, 0.25);
  punch(inset, 22, 36);
  const SourceRaster with_large_hole = inset;
  punch(inset, 58, 60);
  const std::vector<SourceBlock> alone = samplesAlone(*scene, {inset, rasterOf(1, 144, 73, {-180, -90}, 2.5)});
  const auto position = [&](double longitude, double latitude) {
    return terrain::referencePosition(ellipsoidOf(*scene), {latitude * kRadian, longitude * kRadian, 0});
  };
  size_t of_inset = 0, beside_small_hole = 0, of_base = 0;
  for (const SourceBlock& block : alone)
    for (const proto::Geodetic& at : block.samples) {
      const glm::dvec2 degrees = glm::dvec2(at.longitude_rad, at.latitude_rad) / kRadian;
      ASSERT_LT(std::fabs(degrees.y), 89.9);
      const bool is_inside = degrees.x > 10 && degrees.x < 30 && degrees.y > 0 && degrees.y < 20;
      ASSERT_EQ(is_inside, block.input == 0);
      of_base += block.input;
      if (block.input == 1) continue;
      ++of_inset;
      const glm::dvec2 sample = (degrees - glm::dvec2(10, 0)) / 0.25;
      beside_small_hole += glm::distance(sample, glm::dvec2(59)) < 3 ? 1 : 0;
      for (uint32_t y = 0; y < 81; ++y)
        for (uint32_t x = 0; x < 81; ++x) {
          const bool is_edge = x % 80 == 0 || y % 80 == 0 || std::isnan(with_large_hole.metres[y * 81 + x]);
          if (!is_edge) continue;
          ASSERT_GT(glm::distance(position(10 + 0.25 * x, 0.25 * y), position(degrees.x, degrees.y)), kFeather_m);
        }
    }
  EXPECT_GT(of_inset, 500u);
  EXPECT_GT(beside_small_hole, 5u);
  EXPECT_GT(of_base, 5'000u);
}

}  // namespace
}  // namespace foreland::oracle
