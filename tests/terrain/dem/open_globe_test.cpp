// The ground of a whole body from files: the base's own bilinear heights and the geoid's undulations, by an oracle of
// its own (PROJ and sums, no code of terrain/dem); insets where they are, over poles and the antimeridian too.
#include "terrain/dem/open_globe.h"

#include <gtest/gtest.h>
#include <proj.h>

#include <cmath>
#include <glm/geometric.hpp>
#include <memory>
#include <numbers>
#include <string>
#include <vector>

#include "base/rng.h"
#include "tests/support/files.h"
#include "tests/support/map_field.h"
#include "tests/support/seed.h"

namespace foreland::terrain {
namespace {

using test::Field;
using test::writeField;

constexpr double kRadians = std::numbers::pi / 180;

double swells(double lon, double lat) {
  return 900 * std::sin(2 * lon * kRadians) * std::cos(lat * kRadians) + 12 * lat;
}

glm::dvec3 towards(double lon, double lat) {
  lon *= kRadians, lat *= kRadians;
  return {std::cos(lon) * std::cos(lat), std::sin(lon) * std::cos(lat), std::sin(lat)};
}

// By PROJ, from EPSG:4326 with longitude first, or of a grid of undulations.
class Proj {
 public:
  static Proj toCrs(const std::string& crs) {
    Proj out;
    PJ* raw = proj_create_crs_to_crs(out.context_.get(), "EPSG:4326", crs.c_str(), nullptr);
    out.pj_.reset(proj_normalize_for_visualization(out.context_.get(), raw));
    proj_destroy(raw);
    return out;
  }
  static Proj geoid(const std::string& grid) {
    Proj out;
    out.pj_.reset(proj_create(out.context_.get(),
                              ("+proj=pipeline +step +proj=unitconvert +xy_in=deg +xy_out=rad +step +proj=vgridshift "
                               "+multiplier=1 +grids=" +
                               grid)
                                  .c_str()));
    return out;
  }
  bool exists() const { return pj_ != nullptr; }
  PJ_XYZ at(double lon, double lat) const {
    return proj_trans(pj_.get(), PJ_FWD, proj_coord(lon, lat, 0, HUGE_VAL)).xyz;
  }

 private:
  std::unique_ptr<PJ_CONTEXT, decltype(&proj_context_destroy)> context_{proj_context_create(), proj_context_destroy};
  std::unique_ptr<PJ, decltype(&proj_destroy)> pj_{nullptr, proj_destroy};
};

class OpenGlobe : public testing::Test {
 protected:
  OpenGlobe() { base = file("base.tif", {"EPSG:4326", -179, 89, 2, 180, 90, swells}); }

  std::string file(const std::string& name, const Field& f) const { return writeField((folder / name).string(), f); }
  static std::unique_ptr<GlobeSource> opened(const std::vector<std::filesystem::path>& inputs, OpenOptions options) {
    options.is_fenced = false;
    auto source = openGlobe(inputs, options);
    EXPECT_TRUE(source.ok()) << (source.ok() ? "" : source.error().message);
    return source.ok() ? std::move(*source) : nullptr;
  }
  // Heights of the base between its samples, which lie at odd degrees.
  static double ownBilinear(double lon, double lat) {
    const auto sample = [](double x, double y) {
      x -= 360 * std::floor((x + 180) / 360);
      return double{static_cast<float>(swells(x, y))};
    };
    const double x = 2 * std::floor((lon + 1) / 2) - 1, y = 2 * std::floor((lat + 1) / 2) - 1, u = (lon - x) / 2,
                 v = (lat - y) / 2;
    return (1 - v) * ((1 - u) * sample(x, y) + u * sample(x + 2, y)) +
           v * ((1 - u) * sample(x, y + 2) + u * sample(x + 2, y + 2));
  }

  test::TemporaryFolder folder;
  std::string base;
  Rng rng{test::randomSeed()};
};

TEST_F(OpenGlobe, IsTheBilinearBaseAboveTheGeoid) {
  const Proj geoid = Proj::geoid("egm96_15.gtx");
  if (!geoid.exists()) GTEST_SKIP() << "no egm96_15.gtx; install proj-data";
  OpenOptions options;
  options.vertical = "egm96";
  const auto globe = opened({base}, options), flat = opened({base}, {});
  ASSERT_TRUE(globe && flat);
  EXPECT_EQ(globe->info().vertical.zero_surface, proto::ZeroSurface::kEllipsoid);
  EXPECT_EQ(globe->info().vertical.geoid, "EGM96");
  EXPECT_LT(globe->info().vertical.undulations.max_error_m, 1e-3);
  for (int i = 0; i < 5000; ++i) {
    const double lon = rng.uniform(-180, 180), lat = rng.uniform(-89, 89), above_m = ownBilinear(lon, lat);
    const glm::dvec3 direction = rng.uniform(0.1, 9) * towards(lon, lat);
    EXPECT_NEAR(flat->heightAt(direction).metres, above_m, 1e-6) << lon << " " << lat;
    EXPECT_NEAR(globe->heightAt(direction).metres, above_m + geoid.at(lon, lat).z, 1e-3) << lon << " " << lat;
    EXPECT_EQ(globe->heightAt(direction).owner, 0);
  }
}

TEST_F(OpenGlobe, ShowsAnInsetInsideItsFeather) {
  OpenOptions options;
  // Its columns go past the antimeridian.
  options.insets = {{file("fiji.tif", {"EPSG:4326", 178, -14, 0.02, 201, 151,
                                       [](double x, double y) { return 50 * x + 30 * y - 7000; }}),
                     0}};
  options.feather_m = 30000;
  const auto globe = opened({base}, options);
  ASSERT_TRUE(globe);
  ASSERT_EQ(globe->info().inputs.size(), 2u);
  for (int i = 0; i < 5000; ++i) {
    const double lon = rng.uniform(176, 184), lat = rng.uniform(-19, -12);
    const double own_m = 50 * lon + 30 * lat - 7000, base_m = ownBilinear(lon > 180 ? lon - 360 : lon, lat);
    const GlobeHeight at = globe->heightAt(towards(lon, lat));
    const double west = lon - 178, east = 182 - lon, south = lat + 17, north = -14 - lat,
                 edge = std::min({west, east, south, north});
    if (edge > 0.3) {
      EXPECT_NEAR(at.metres, own_m, 1e-2) << lon << " " << lat;
      EXPECT_EQ(at.owner, 0);
    } else if (edge < 0) {
      EXPECT_NEAR(at.metres, base_m, 1e-6) << lon << " " << lat;
      EXPECT_EQ(at.owner, 1);
    } else {
      EXPECT_GE(at.metres, std::min(own_m, base_m) - 0.01);
      EXPECT_LE(at.metres, std::max(own_m, base_m) + 0.01);
    }
  }
}

TEST_F(OpenGlobe, ShowsAnInsetOverAPole) {
  OpenOptions options;
  options.insets = {{file("pole.tif", {"EPSG:3413", -400000, 400000, 5000, 161, 161,
                                       [](double x, double y) { return 0.002 * x - 0.001 * y + 300; }}),
                     0}};
  options.feather_m = 50000;
  const auto globe = opened({base}, options);
  ASSERT_TRUE(globe);
  const Proj polar = Proj::toCrs("EPSG:3413");
  for (int i = 0; i < 2000; ++i) {
    const double lon = rng.uniform(-180, 180), lat = rng.uniform(87.2, 90);
    const PJ_XYZ p = polar.at(lon, lat);
    const GlobeHeight at = globe->heightAt(towards(lon, lat));
    if (std::hypot(p.x, p.y) > 330000) continue;
    EXPECT_NEAR(at.metres, 0.002 * p.x - 0.001 * p.y + 300, 1e-2) << lon << " " << lat;
    EXPECT_EQ(at.owner, 0);
  }
}

// A square of directions around one.
GlobePatch patchAround(const glm::dvec3& middle, double angle_rad) {
  GlobePatch patch{.middle = middle, .angle_rad = 1.5 * angle_rad, .side = 5, .directions = {}};
  const glm::dvec3 east = glm::normalize(glm::cross(glm::dvec3(0.3, 0.1, 0.9), middle)),
                   north = glm::cross(middle, east);
  for (double y = -2; y <= 2; ++y)
    for (double x = -2; x <= 2; ++x) patch.directions.push_back(middle + 0.5 * angle_rad * (x * east + y * north));
  return patch;
}

TEST_F(OpenGlobe, TellsWhereAnInsetIs) {
  OpenOptions options;
  options.insets = {
      {file("alps.tif", {"EPSG:32632", 400000, 5200000, 100, 301, 201, [](double, double) { return 1000.0; }}), 0}};
  const auto globe = opened({base}, options);
  ASSERT_TRUE(globe);
  EXPECT_NEAR(globe->info().inputs[0].spacing_m, 100, 0.2);
  const double base_m = globe->info().inputs[1].spacing_m;
  EXPECT_NEAR(base_m, 222e3, 2e3);
  for (uint32_t row = 0; row < globe->rowsOf(0); row += 20) {
    std::vector<GlobeSample> samples;
    globe->samplesOf(0, row, samples);
    ASSERT_EQ(samples.size(), 301u);
    for (const GlobeSample& s : samples) {
      EXPECT_NEAR(s.metres, 1000, 1e-3);
      const double angle = std::exp(rng.uniform(std::log(1e-6), std::log(1.0)));
      const glm::dvec3 off(rng.uniform(-1, 1), rng.uniform(-1, 1), rng.uniform(-1, 1));
      const GlobePatch patch = patchAround(glm::normalize(s.direction + 0.3 * angle * off), angle);
      EXPECT_LT(globe->spacingIn(patch), 101) << angle;
    }
  }
  // 30 km by 20 km, so what is 100 km away does not meet it.
  EXPECT_EQ(globe->spacingIn(patchAround(towards(7.9, 48.2), 0.002)), base_m);
  EXPECT_EQ(globe->spacingIn(patchAround(towards(-170, -46), 0.3)), base_m);
}

TEST_F(OpenGlobe, LeavesOutWhatIsCoarserThanTheBase) {
  OpenOptions options;
  options.insets = {{file("coarse.tif", {"EPSG:4326", 0, 40, 4, 8, 8, [](double, double) { return 5000.0; }}), 0}};
  const auto globe = opened({base}, options);
  ASSERT_TRUE(globe);
  EXPECT_EQ(globe->info().inputs.size(), 1u);
  EXPECT_NEAR(globe->heightAt(towards(10, 30)).metres, ownBilinear(10, 30), 1e-6);
}

TEST_F(OpenGlobe, RefusesABaseThatIsNotAroundTheBody) {
  OpenOptions options;
  options.is_fenced = false;
  const std::string half = file("half.tif", {"EPSG:4326", -89, 89, 2, 90, 90, swells}),
                    map =
                        file("map.tif", {"EPSG:32632", 500000, 5150000, 30, 9, 9, [](double, double) { return 1.0; }});
  for (const auto& [path, words] : {std::pair(half, "around a globe"), std::pair(map, "latitude and longitude")}) {
    const auto refused = openGlobe({path}, options);
    ASSERT_FALSE(refused.ok());
    EXPECT_NE(refused.error().message.find(words), std::string::npos) << refused.error().message;
    EXPECT_NE(refused.error().message.find(path), std::string::npos) << refused.error().message;
  }
}

}  // namespace
}  // namespace foreland::terrain
