// A raster around a body is one surface: samples are met, nothing shows of the seam between its last and its first
// column, and a pole has one height from wherever it is approached.
#include "terrain/dem/planet/planet_raster.h"

#include <gtest/gtest.h>

#include <cmath>

#include "base/rng.h"
#include "tests/support/seed.h"

namespace foreland::terrain {
namespace {

constexpr uint32_t kColumns = 36, kRows = 18;

// Ten degrees from sample to sample, these in the middles of cells; the columns begin anywhere.
struct Planet {
  explicit Planet(uint64_t seed, uint32_t overlap = 0) : rng(seed), samples{kColumns + overlap, kRows, {}} {
    first = {rng.uniform(-400, 400), -85};
    for (uint32_t y = 0; y < kRows; ++y)
      for (uint32_t x = 0; x < kColumns + overlap; ++x)
        samples.metres.push_back(x < kColumns ? static_cast<float>(rng.uniform(-9000, 6000))
                                              : samples.at(x - kColumns, y));
  }
  PlanetRaster raster() const { return *PlanetRaster::of(samples, first, {10, 10}); }

  Rng rng;
  Samples samples;
  glm::dvec2 first{0};
};

TEST(PlanetRaster, MeetsItsSamplesOnAnyTurn) {
  const Planet planet(test::randomSeed(), 2);
  const PlanetRaster raster = planet.raster();
  EXPECT_EQ(raster.columns(), kColumns);
  for (uint32_t y = 0; y < kRows; ++y)
    for (uint32_t x = 0; x < kColumns; ++x)
      for (const double turn : {-360.0, 0.0, 720.0}) {
        EXPECT_NEAR(raster.heightAt(raster.degreesOf(x, y) + glm::dvec2(turn, 0)), planet.samples.at(x, y), 1e-6);
        EXPECT_EQ(raster.sampleAt(x, y), planet.samples.at(x, y));
      }
}

TEST(PlanetRaster, IsContinuousAroundTheBody) {
  Planet planet(test::randomSeed());
  const PlanetRaster raster = planet.raster();
  constexpr double kStep = 1e-6, kSteepest = 15000.0 / 5;  // metres a degree, where a row leads to its pole
  for (int i = 0; i < 20000; ++i) {
    const bool at_seam = i % 2 == 0;
    const glm::dvec2 p(at_seam ? planet.first.x + planet.rng.uniform(-1e-6, 1e-6) : planet.rng.uniform(-180, 180),
                       planet.rng.uniform(-90, 90 - kStep));
    const double h = raster.heightAt(p);
    EXPECT_NEAR(raster.heightAt(p + glm::dvec2(kStep, 0)), h, 1.01 * kStep * kSteepest);
    EXPECT_NEAR(raster.heightAt(p + glm::dvec2(0, kStep)), h, 1.01 * kStep * kSteepest);
  }
}

TEST(PlanetRaster, GivesAPoleTheMeanOfItsRow) {
  Planet planet(test::randomSeed());
  const PlanetRaster raster = planet.raster();
  for (const uint32_t row : {0u, kRows - 1}) {
    double mean = 0;
    for (uint32_t x = 0; x < kColumns; ++x) mean += planet.samples.at(x, row) / double{kColumns};
    for (int i = 0; i < 100; ++i)
      EXPECT_NEAR(raster.heightAt({planet.rng.uniform(-180, 180), row == 0 ? -90 : 90}), mean, 1e-6);
  }
}

TEST(PlanetRaster, TakesARowThatIsThePoleForOnePoint) {
  Planet planet(test::randomSeed());
  const auto raster = PlanetRaster::of(planet.samples, {0, -90}, {10, 180.0 / (kRows - 1)});
  ASSERT_TRUE(raster.ok());
  for (const double latitude : {-90.0, 90.0}) {
    const double height_m = raster->heightAt({0, latitude});
    for (uint32_t x = 0; x < kColumns; ++x) EXPECT_NEAR(raster->heightAt({10.0 * x + 3, latitude}), height_m, 1e-3);
  }
  EXPECT_EQ(raster->sampleAt(0, 0), raster->sampleAt(17, 0));
}

TEST(PlanetRaster, RefusesWhatDoesNotGoAround) {
  const Planet planet(1);
  const auto refusal = [&](glm::dvec2 first, glm::dvec2 step) {
    const auto raster = PlanetRaster::of(planet.samples, first, step);
    return raster.ok() ? std::string() : raster.error().message;
  };
  EXPECT_EQ(refusal({0, -85}, {10, 10}), "");
  EXPECT_NE(refusal({0, -85}, {9.5, 10}).find("around a globe"), std::string::npos);
  EXPECT_NE(refusal({0, -60}, {10, 7}).find("both poles"), std::string::npos);
  EXPECT_NE(refusal({0, -85}, {10, 9}).find("both poles"), std::string::npos);
  EXPECT_NE(refusal({0, -95}, {10, 10}).find("both poles"), std::string::npos);
}

}  // namespace
}  // namespace foreland::terrain
