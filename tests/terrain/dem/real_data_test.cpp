// Every real elevation file: it opens as what it is, or ends in an error that tells the way out.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "terrain/dem/open.h"
#include "terrain/elevation_source.h"
#include "tests/support/data.h"

namespace foreland::terrain {
namespace {

constexpr double kDegree = std::numbers::pi / 180;

struct Known {
  const char* file;
  uint32_t width, height;
  proto::FrameKind kind;
  float lowest_m, highest_m;
  double void_share;
  const char* note;  // words of one of its notes, or empty
};

void PrintTo(const Known& known, std::ostream* out) { *out << known.file; }

constexpr auto kPlanar = proto::FrameKind::kPlanar;
constexpr auto kGeographic = proto::FrameKind::kGeographic;

constexpr Known kKnown[] = {
    {"dem/msh/msh_base_utm10_10m.tif", 1341, 1978, kPlanar, 591, 2538, 0, ""},
    {"dem/msh/SainteHelens.dem", 327, 468, kPlanar, 682, 2543, 0.027, ""},
    {"dem/srtm/N46E008.tif", 1201, 1201, kGeographic, 187, 4173, 0.072, ""},
    {"dem/srtm/N41E001.hgt.zip", 1201, 1201, kGeographic, -20, 1204, 0.0001, ""},
    {"dem/srtm/N42E001.hgt.zip", 1201, 1201, kGeographic, 349, 3100, 0.0053, ""},
    {"dem/srtm/N48W125.hgt.zip", 3601, 3601, kGeographic, -13, 1095, 0.5, ""},
    {"dem/srtm/N44W072.hgt", 1201, 1201, kGeographic, 115, 1908, 0, ""},
    {"dem/srtm/N49W124.tif", 1201, 1201, kGeographic, -26, 2630, 0.0178, ""},
    {"dem/srtm/mt_rainier_90m.tif", 1201, 1201, kGeographic, 263, 4371, 0.0063, ""},
    {"dem/srtm/mt_fuji_90m.tif", 1201, 1201, kGeographic, -16, 3742, 0.0017, ""},
    {"dem/global/etopo20.cdf", 1081, 540, kGeographic, -9027, 6229, 0, "look like degrees"},
    {"dem/global/gm_el_v2_02_02.zip", 7200, 10800, kGeographic, -13, 4203, 0.975, "-9999"},
    {"dem/misc/bigtujunga.tif", 1197, 643, kPlanar, 315, 2295, 0, ""},
    {"dem/misc/pre_runout_DEM.asc", 80, 122, kPlanar, 189, 582.4f, 0.0125, "taken as metres"},
    {"dem/misc/DEM_of_Difference.asc", 80, 122, kPlanar, -15.7f, 7.8f, 0.977, "taken as metres"},
    {"dem/misc/mars_gale_msl_1m.tif", 348, 337, kPlanar, -4473, -4438, 0, ""},
    {"dem/misc/craterlake-elev-16bit-30m.tif", 429, 279, kGeographic, 1289, 1880, 0.33, "-32767"},
    {"dem/odd/us_25m.dem", 1405, 621, kGeographic, -73, 4005, 0.064, "whatever its suffix"},
    {"dem/odd/sba_elev32_wgs84_512.tif", 512, 512, kGeographic, 2.5f, 20.7f, 0, "corrupt"},
};

class DemRealData : public ::testing::TestWithParam<Known> {};

TEST_P(DemRealData, OpensAsWhatItIs) {
  const Known& known = GetParam();
  FORELAND_DATA_OR_SKIP(path, known.file);
  auto source = openElevation({path}, {});
  ASSERT_TRUE(source.ok()) << source.error().message;
  const ElevationInfo& info = (*source)->info();
  EXPECT_EQ(info.width, known.width);
  EXPECT_EQ(info.height, known.height);
  EXPECT_EQ(info.frame.kind, known.kind);
  EXPECT_TRUE(info.frame.validate(info.width - 1.0, info.height - 1.0).ok());
  std::vector<float> rows(size_t{info.width} * info.height);
  ASSERT_TRUE((*source)->readRows(0, info.height, rows).ok());
  float lowest = 1e9f, highest = -1e9f;
  uint64_t voids = 0;
  for (const float h : rows) {
    if (std::isnan(h))
      ++voids;
    else
      lowest = std::min(lowest, h), highest = std::max(highest, h);
  }
  EXPECT_NEAR(lowest, known.lowest_m, 0.6);
  EXPECT_NEAR(highest, known.highest_m, 0.6);
  EXPECT_NEAR(static_cast<double>(voids) / static_cast<double>(rows.size()), known.void_share, 0.006);
  const bool noted = std::any_of(info.notes.begin(), info.notes.end(),
                                 [&](const std::string& note) { return note.find(known.note) != std::string::npos; });
  EXPECT_TRUE(noted || *known.note == 0) << known.note;
}

INSTANTIATE_TEST_SUITE_P(Files, DemRealData, ::testing::ValuesIn(kKnown));

// What must end in an error, with the words it must hold.
void expectError(const std::filesystem::path& path, const std::string& words) {
  const auto source = openElevation({path}, {});
  ASSERT_FALSE(source.ok());
  EXPECT_NE(source.error().message.find(path.filename().string()), std::string::npos) << source.error().message;
  EXPECT_NE(source.error().message.find(words), std::string::npos) << source.error().message;
}

TEST(DemRealErrors, ACutFileIsFoundOut) {
  FORELAND_DATA_OR_SKIP(path, "dem/odd/corrupt.tif");
  expectError(path, "cut short");
}

TEST(DemRealErrors, AFileOfVoidsIsRefused) {
  FORELAND_DATA_OR_SKIP(path, "dem/odd/all-nodata.tif");
  expectError(path, "--nodata");
}

TEST(DemReal, ColoursThatAreHeightsAreFoundOut) {
  FORELAND_DATA_OR_SKIP(path, "dem/misc/terrarium_256.png");
  auto source = openElevation({path}, {});
  ASSERT_TRUE(source.ok()) << source.error().message;
  EXPECT_TRUE(std::ranges::any_of((*source)->info().notes, [](const std::string& note) {
    return note.find("--encoding terrarium") != std::string::npos;
  }));
  std::vector<float> rows(256 * 256);
  ASSERT_TRUE((*source)->readRows(0, 256, rows).ok());
  EXPECT_NEAR(*std::min_element(rows.begin(), rows.end()), 715, 1);
  EXPECT_NEAR(*std::max_element(rows.begin(), rows.end()), 2489, 1);
}

TEST(DemRealErrors, ImageryIsRefused) {
  FORELAND_DATA_OR_SKIP(path, "imagery/sba_rgb.tif");
  expectError(path, "picture");
}

TEST(DemRealMosaic, NeighbouringTilesShareTheirSeam) {
  FORELAND_DATA_OR_SKIP(south, "dem/srtm/N41E001.hgt.zip");
  FORELAND_DATA_OR_SKIP(north, "dem/srtm/N42E001.hgt.zip");
  auto alone = openElevation({south}, {}), other = openElevation({north}, {}), both = openElevation({south, north}, {});
  ASSERT_TRUE(alone.ok() && other.ok() && both.ok());
  ASSERT_EQ((*both)->info().height, 2401u);
  EXPECT_NEAR((*both)->info().frame.latitude0_rad, 41 * kDegree, 1e-12);
  std::vector<float> whole(size_t{1201} * 2401), a(size_t{1201} * 1201), b(a);
  ASSERT_TRUE((*both)->readRows(0, 2401, whole).ok() && (*alone)->readRows(0, 1201, a).ok() &&
              (*other)->readRows(0, 1201, b).ok());
  const auto same = [](float x, float y) { return x == y || (std::isnan(x) && std::isnan(y)); };
  EXPECT_TRUE(std::equal(a.begin(), a.end() - 1201, whole.begin(), same));
  EXPECT_TRUE(std::equal(b.begin() + 1201, b.end(), whole.begin() + size_t{1201} * 1201, same));
  for (size_t x = 0; x < 1201; ++x) {
    const float seam = whole[size_t{1200} * 1201 + x], from_south = a[size_t{1200} * 1201 + x];
    EXPECT_TRUE(same(seam, std::isnan(from_south) ? b[x] : from_south));
  }
}

TEST(DemRealMosaic, WhatLiesTooFarAwayIsRefusedByName) {
  FORELAND_DATA_OR_SKIP(map, "dem/msh/msh_base_utm10_10m.tif");
  FORELAND_DATA_OR_SKIP(globe, "dem/srtm/N46E008.tif");
  const auto source = openElevation({map, globe}, {});
  ASSERT_FALSE(source.ok());
  EXPECT_NE(source.error().message.find("N46E008.tif"), std::string::npos) << source.error().message;
  EXPECT_NE(source.error().message.find("msh_base"), std::string::npos) << source.error().message;
}

}  // namespace
}  // namespace foreland::terrain
