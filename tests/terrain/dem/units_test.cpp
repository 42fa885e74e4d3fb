// What a file's numbers mean: units of heights, colours that are heights, maps that stretch, places by control points,
// rows that go north. The same hills each time, so what is read must be the same.
#include <cpl_conv.h>
#include <gdal.h>
#include <gtest/gtest.h>
#include <ogr_srs_api.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "terrain/dem/formats/gdal_raster.h"
#include "terrain/dem/open.h"
#include "tests/support/files.h"

namespace foreland::terrain {
namespace {

constexpr int kSide = 40;

double hill(double column, double row) { return 600 + 80 * std::sin(0.2 * column) + 50 * std::cos(0.15 * row); }

struct Written {
  std::string crs = "EPSG:32632";
  std::array<double, 6> transform{400000, 30, 0, 5150000, 0, -30};
  double per_metre = 1;  // of the numbers in the file
  std::string unit{};    // of the band
  int first_column = 0;
  bool rows_go_north = false, has_control_points = false;
};

std::string write(const test::TemporaryFolder& folder, const std::string& name, const Written& w) {
  registerGdalDrivers();
  const std::string path = folder / name;
  GDALDatasetH dataset = GDALCreate(GDALGetDriverByName("GTiff"), path.c_str(), kSide, kSide, 1, GDT_Float32, nullptr);
  OGRSpatialReferenceH crs = OSRNewSpatialReference(nullptr);
  EXPECT_EQ(OSRSetFromUserInput(crs, w.crs.c_str()), OGRERR_NONE);
  OSRSetAxisMappingStrategy(crs, OAMS_TRADITIONAL_GIS_ORDER);
  std::array<double, 6> t = w.transform;
  t[0] += w.first_column * t[1];
  if (w.rows_go_north) t[3] += kSide * t[5], t[5] = -t[5];
  if (w.has_control_points) {
    std::array<GDAL_GCP, 4> points{};
    GDALInitGCPs(4, points.data());
    for (size_t i = 0; i < 4; ++i) {
      points[i].dfGCPPixel = i % 2 == 0 ? 0 : kSide;
      points[i].dfGCPLine = i < 2 ? 0 : kSide;
      points[i].dfGCPX = t[0] + points[i].dfGCPPixel * t[1];
      points[i].dfGCPY = t[3] + points[i].dfGCPLine * t[5];
    }
    EXPECT_EQ(GDALSetGCPs2(dataset, 4, points.data(), crs), CE_None);
    GDALDeinitGCPs(4, points.data());
  } else {
    EXPECT_EQ(GDALSetGeoTransform(dataset, t.data()), CE_None);
    EXPECT_EQ(GDALSetSpatialRef(dataset, crs), CE_None);
  }
  OSRDestroySpatialReference(crs);
  if (!w.unit.empty()) { EXPECT_EQ(GDALSetRasterUnitType(GDALGetRasterBand(dataset, 1), w.unit.c_str()), CE_None); }
  std::vector<float> heights;
  for (int row = 0; row < kSide; ++row)
    for (int column = 0; column < kSide; ++column)
      heights.push_back(
          static_cast<float>(w.per_metre * hill(column + w.first_column, w.rows_go_north ? kSide - 1 - row : row)));
  EXPECT_EQ(GDALRasterIO(GDALGetRasterBand(dataset, 1), GF_Write, 0, 0, kSide, kSide, heights.data(), kSide, kSide,
                         GDT_Float32, 0, 0),
            CE_None);
  GDALClose(dataset);
  return path;
}

// Rows of a source go north (ElevationSource).
void expectHills(ElevationSource& source, double within_m = 0.01) {
  const uint32_t width = source.info().width, height = source.info().height;
  std::vector<float> rows(size_t{width} * height);
  ASSERT_TRUE(source.readRows(0, height, rows).ok());
  for (uint32_t y = 0; y < height; ++y)
    for (uint32_t x = 0; x < width; ++x)
      ASSERT_NEAR(rows[size_t{y} * width + x], hill(x, height - 1 - y), within_m) << x << ' ' << y;
}

bool hasNote(const ElevationSource& source, const std::string& words) {
  return std::ranges::any_of(source.info().notes,
                             [&](const std::string& note) { return note.find(words) != std::string::npos; });
}

constexpr double kFeet = 3937.0 / 1200;

TEST(UnitOfHeights, IsTheBandsElseTheReferenceSystemsElseMetres) {
  const test::TemporaryFolder folder;
  for (const Written& w :
       {Written{}, Written{.per_metre = 100, .unit = "cm"}, Written{.crs = "EPSG:32632+6360", .per_metre = kFeet}}) {
    const auto source = openElevation({write(folder, "hills.tif", w)}, {});
    ASSERT_TRUE(source.ok()) << source.error().message;
    expectHills(**source);
    EXPECT_EQ(hasNote(**source, "--height-unit"), w.per_metre != 1) << w.crs;
  }
}

TEST(UnitOfHeights, IsWhatTheUserSays) {
  const test::TemporaryFolder folder;
  const auto source =
      openElevation({write(folder, "hills.tif", {.per_metre = 100, .unit = "m"})}, {.height_unit = 0.01});
  ASSERT_TRUE(source.ok()) << source.error().message;
  expectHills(**source);
}

TEST(UnitOfHeights, IsDoubtedWhereTheMapIsInFeet) {
  const test::TemporaryFolder folder;
  const auto source = openElevation(
      {write(folder, "hills.tif", {.crs = "EPSG:2263", .transform = {980000, 100, 0, 200000, 0, -100}})}, {});
  ASSERT_TRUE(source.ok()) << source.error().message;
  EXPECT_TRUE(hasNote(**source, "nothing says what its heights are in"));
}

TEST(ControlPoints, PlaceAFile) {
  const test::TemporaryFolder folder;
  const auto source = openElevation({write(folder, "hills.tif", {.has_control_points = true})}, {});
  ASSERT_TRUE(source.ok()) << source.error().message;
  EXPECT_NEAR((*source)->info().frame.axis_x_m.x, 30, 0.1);
  EXPECT_TRUE(hasNote(**source, "control points"));
  expectHills(**source, 1);
}

TEST(MercatorsMap, IsBuiltInLatitudeAndLongitudeUnlessTheMapIsWanted) {
  const test::TemporaryFolder folder;
  const std::string path =
      write(folder, "hills.tif", {.crs = "EPSG:3857", .transform = {900000, 30, 0, 8400000, 0, -30}});
  const auto truth = openElevation({path}, {});
  ASSERT_TRUE(truth.ok()) << truth.error().message;
  EXPECT_EQ((*truth)->info().frame.kind, proto::FrameKind::kGeographic);
  EXPECT_TRUE(hasNote(**truth, "--frame projected"));
  const auto map = openElevation({path}, {.frame = FrameChoice::kPlanar});
  ASSERT_TRUE(map.ok()) << map.error().message;
  EXPECT_EQ((*map)->info().frame.kind, proto::FrameKind::kPlanar);
  EXPECT_TRUE(hasNote(**map, "times as long"));
  expectHills(**map);
  // 40 samples of 30 m of the map are half as long on the ground at 60 degrees.
  const proto::Frame& f = (*truth)->info().frame;
  const double north_m = 6.37e6 * f.latitude_step_rad * (*truth)->info().height;
  EXPECT_NEAR(north_m, 600, 20);
}

TEST(MixedOrientations, MakeOneMosaic) {
  const test::TemporaryFolder folder;
  const std::string left = write(folder, "left.tif", {}),
                    right = write(folder, "right.tif", {.first_column = kSide, .rows_go_north = true});
  for (const auto& files :
       {std::vector<std::filesystem::path>{left, right}, std::vector<std::filesystem::path>{right, left}}) {
    const auto source = openElevation(files, {});
    ASSERT_TRUE(source.ok()) << source.error().message;
    EXPECT_EQ((*source)->info().width, 2u * kSide);
    expectHills(**source);
  }
}

}  // namespace
}  // namespace foreland::terrain
