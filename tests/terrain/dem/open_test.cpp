// Opening elevation files made on the spot: orientation, frames, voids, mosaics, and what must be refused.
#include "terrain/dem/open.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "tests/terrain/dem/dem_files.h"

namespace foreland::terrain {
namespace {

constexpr double kDegree = std::numbers::pi / 180;
constexpr const char* kMetres = "xllcorner 1000\nyllcorner 2000\ncellsize 10\nNODATA_value -9999\n";
constexpr const char* kUtm =
    "PROJCS[\"UTM 32N\",GEOGCS[\"WGS 84\",DATUM[\"WGS_1984\",SPHEROID[\"WGS "
    "84\",6378137,298.257223563]],PRIMEM[\"Greenwich\",0],"
    "UNIT[\"degree\",0.0174532925199433]],PROJECTION[\"Transverse_Mercator\"],PARAMETER[\"latitude_of_origin\",0],"
    "PARAMETER[\"central_meridian\",9],PARAMETER[\"scale_factor\",0.9996],PARAMETER[\"false_easting\",500000],"
    "PARAMETER[\"false_northing\",0],UNIT[\"%s\",%s]]";

std::string projection(const std::string& unit, const std::string& metres) {
  std::string text = kUtm;
  text.replace(text.find("%s"), 2, unit);
  text.replace(text.find("%s"), 2, metres);
  return text;
}

using DemOpen = DemFiles;

TEST_F(DemOpen, RowZeroIsTheSouthernmostAndPositionsArePixelCentres) {
  auto source = open(asciiGrid("grid.asc", 4, 3, kMetres));
  ASSERT_TRUE(source.ok()) << source.error().message;
  EXPECT_EQ(readAll(**source), (std::vector<float>{200, 201, 202, 203, 100, 101, 102, 103, 0, 1, 2, 3}));
  const proto::Frame& frame = (*source)->info().frame;
  EXPECT_EQ(frame.kind, proto::FrameKind::kPlanar);
  EXPECT_EQ(frame.axis_x_m, glm::dvec2(10, 0));
  EXPECT_EQ(frame.axis_y_m, glm::dvec2(0, 10));
  EXPECT_EQ(frame.anchor, glm::dvec2(2, 1));
  EXPECT_EQ(frame.map_origin_m, glm::dvec2(1025, 2015));
}

TEST_F(DemOpen, RowsMayBeReadInAnyWindows) {
  auto source = open(asciiGrid("tall.asc", 3, 200, kMetres));
  ASSERT_TRUE(source.ok());
  const std::vector<float> whole = readAll(**source);
  for (const uint32_t first : {150u, 10u, 63u, 199u, 0u}) {
    std::vector<float> row(3);
    ASSERT_TRUE((*source)->readRows(first, 1, row).ok());
    EXPECT_TRUE(std::equal(row.begin(), row.end(), whole.begin() + 3 * first));
  }
}

TEST_F(DemOpen, FeetOfAMapBecomeMetres) {
  write("feet.prj", projection("Foot", "0.3048"));
  auto source = open(asciiGrid("feet.asc", 4, 3, kMetres));
  ASSERT_TRUE(source.ok()) << source.error().message;
  EXPECT_NEAR((*source)->info().frame.axis_x_m.x, 3.048, 1e-12);
  EXPECT_FALSE((*source)->info().crs_wkt.empty());
}

TEST_F(DemOpen, TaggedVoidsAreVoids) {
  const auto path = write("holes.asc", std::string("ncols 3\nnrows 2\n") + kMetres + "1.5 -9999 3\n4 nan 6\n");
  auto source = open(path);
  ASSERT_TRUE(source.ok()) << source.error().message;
  const std::vector<float> heights = readAll(**source);
  EXPECT_TRUE(std::isnan(heights[1]));
  EXPECT_TRUE(std::isnan(heights[4]));
  EXPECT_EQ(heights[0], 4);
}

TEST_F(DemOpen, UntaggedSentinelsAreVoidsOnlyFarFromOtherHeights) {
  const std::string head = "ncols 3\nnrows 2\nxllcorner 0\nyllcorner 0\ncellsize 10\n";
  auto land = open(write("land.asc", head + "1 -32768 3\n4 5 -999\n"));
  ASSERT_TRUE(land.ok()) << land.error().message;
  EXPECT_TRUE(std::isnan(readAll(**land)[4]));
  EXPECT_TRUE(std::isnan(readAll(**land)[2]));
  EXPECT_TRUE(hasNote(**land, "taken as voids"));
  auto sea = open(write("sea.asc", head + "-990 -999 -1010\n4 5 6\n"));
  ASSERT_TRUE(sea.ok());
  EXPECT_EQ(readAll(**sea)[4], -999);
}

TEST_F(DemOpen, NodataMayBeNamedByTheUser) {
  auto source = open(asciiGrid("grid.asc", 4, 3, kMetres), {.nodata = 101});
  ASSERT_TRUE(source.ok());
  EXPECT_TRUE(std::isnan(readAll(**source)[5]));
}

TEST_F(DemOpen, AbsurdHeightsAreVoidsAndSaid) {
  auto source = open(write("absurd.asc", std::string("ncols 2\nnrows 2\n") + kMetres + "1 2000000\n3 -50000\n"));
  ASSERT_TRUE(source.ok());
  EXPECT_TRUE(std::isnan(readAll(**source)[3]));
  EXPECT_TRUE(std::isnan(readAll(**source)[1]));
  EXPECT_TRUE(hasNote(**source, "outside -12000 to 100000 m"));
}

TEST_F(DemOpen, AnSrtmTileStandsOnTheEllipsoid) {
  auto source = open(srtmTile("N46E008.hgt"));
  ASSERT_TRUE(source.ok()) << source.error().message;
  const proto::Frame& frame = (*source)->info().frame;
  EXPECT_EQ(frame.kind, proto::FrameKind::kGeographic);
  EXPECT_NEAR(frame.latitude0_rad, 46 * kDegree, 1e-12);
  EXPECT_NEAR(frame.longitude0_rad, 8 * kDegree, 1e-12);
  EXPECT_NEAR(frame.latitude_step_rad, kDegree / 1200, 1e-15);
  EXPECT_NEAR(frame.origin.latitude_rad, 46.5 * kDegree, 1e-12);
  EXPECT_EQ(frame.origin.height_m, 0);
  EXPECT_EQ(frame.semi_major_m, 6378137.0);
  std::vector<float> south(1201);
  ASSERT_TRUE((*source)->readRows(0, 1, south).ok());
  EXPECT_EQ(south[0], 1210);
}

TEST_F(DemOpen, TilesShareTheirSeamExactly) {
  const auto south = srtmTile("N46E008.hgt"), north = srtmTile("N47E008.hgt");
  auto source = openElevation({south, north}, {});
  ASSERT_TRUE(source.ok()) << source.error().message;
  ASSERT_EQ((*source)->info().width, 1201u);
  ASSERT_EQ((*source)->info().height, 2401u);
  std::vector<float> rows(3 * 1201);
  ASSERT_TRUE((*source)->readRows(1199, 3, rows).ok());
  EXPECT_EQ(rows[0], 11);                // one row south of the seam, in the southern tile
  EXPECT_EQ(rows[1201], 10);             // the seam: the first input counts
  EXPECT_EQ(rows[2 * 1201], 10 + 1199);  // one row north of it, in the northern tile
}

TEST_F(DemOpen, WhereOneTileHasAVoidTheOtherFillsIn) {
  const auto holed = srtmTile("N46E008.hgt", 0 + 1), north = srtmTile("N47E008.hgt");
  auto source = openElevation({holed, north}, {});
  ASSERT_TRUE(source.ok()) << source.error().message;
  std::vector<float> rows(2 * 1201);
  ASSERT_TRUE((*source)->readRows(1199, 2, rows).ok());
  EXPECT_TRUE(std::isnan(rows[0]));
  EXPECT_EQ(rows[1201], 10);
}

TEST_F(DemOpen, AMosaicMayCrossTheDateLine) {
  auto source = openElevation({srtmTile("N10E179.hgt"), srtmTile("N10W180.hgt")}, {});
  ASSERT_TRUE(source.ok()) << source.error().message;
  EXPECT_EQ((*source)->info().width, 2401u);
  EXPECT_NEAR((*source)->info().frame.longitude0_rad, 179 * kDegree, 1e-12);
}

TEST_F(DemOpen, MosaicsWithAFileOfNoReferenceSystemAreRefusedByName) {
  const auto a = asciiGrid("a.asc", 4, 3, kMetres);
  write("utm.prj", projection("metre", "1"));
  const auto utm = asciiGrid("utm.asc", 4, 3, kMetres);
  expectRefusal(openElevation({a, utm}, {}), utm, "reference systems");
}

TEST_F(DemOpen, DegreesWithoutAReferenceSystemAreRecognised) {
  const std::string degrees = "xllcorner 8\nyllcorner 46\ncellsize 0.01\n";
  auto source = open(asciiGrid("alps.asc", 20, 20, degrees));
  ASSERT_TRUE(source.ok());
  EXPECT_EQ((*source)->info().frame.kind, proto::FrameKind::kGeographic);
  EXPECT_TRUE(hasNote(**source, "look like degrees"));
  auto planar = open(asciiGrid("alps.asc", 20, 20, degrees), {.frame = FrameChoice::kPlanar});
  ASSERT_TRUE(planar.ok());
  EXPECT_EQ((*planar)->info().frame.axis_x_m.x, 0.01);
}

TEST_F(DemOpen, AFrameThatCannotBeMeantIsRefused) {
  write("utm.prj", projection("metre", "1"));
  const auto utm = asciiGrid("utm.asc", 4, 3, kMetres);
  expectRefusal(open(utm, {.frame = FrameChoice::kGeographic}), utm, "gdalwarp");
  expectRefusal(open(utm, {.spacing_m = 5}), utm, "--spacing");
  const auto plain = asciiGrid("plain.asc", 4, 3, kMetres);
  expectRefusal(open(plain, {.frame = FrameChoice::kGeographic}), plain, "degrees");
  expectRefusal(open(plain, {.spacing_m = -1}), plain, "--spacing");
}

TEST_F(DemOpen, GeographicDataMayBeFlattened) {
  auto source = open(srtmTile("N46E008.hgt"), {.frame = FrameChoice::kPlanar});
  ASSERT_TRUE(source.ok()) << source.error().message;
  EXPECT_EQ((*source)->info().frame.kind, proto::FrameKind::kPlanar);
  EXPECT_NEAR((*source)->info().frame.axis_y_m.y, 92.6, 0.1);
  EXPECT_NEAR((*source)->info().frame.axis_x_m.x, 63.9, 0.1);
}

TEST_F(DemOpen, FilesThatAreNoElevationAreRefusedWithTheWayOut) {
  expectRefusal(open(folder_ / "missing.tif"), "missing.tif", "no such file");
  expectRefusal(open(folder_), folder_, "directory");
  expectRefusal(open(write("empty.tif", "")), "empty.tif", "empty file");
  expectRefusal(open(write("text.tif", "this is not a raster\n")), "text.tif", "recognises");
  expectRefusal(open(write("short.hgt", "xxxx")), "short.hgt", "N46E008.hgt");
  expectRefusal(open(write("junk.zip", "PK\x03\x04 junk")), "junk.zip", "archive");
  expectRefusal(open(write("junk.exr", "\x76\x2f\x31\x01 junk")), "junk.exr", "OpenEXR");
  EXPECT_FALSE(openElevation({}, {}).ok());
}

TEST_F(DemOpen, VoidsAloneAreRefused) {
  const auto path = write("void.asc", std::string("ncols 2\nnrows 2\n") + kMetres + "-9999 -9999\n-9999 -9999\n");
  expectRefusal(open(path), path, "--nodata");
}

TEST_F(DemOpen, AFileCutShortIsFoundOut) {
  const auto path = asciiGrid("cut.asc", 50, 50, kMetres);
  std::filesystem::resize_file(path, std::filesystem::file_size(path) / 2);
  expectRefusal(open(path), path, "cut short");
}

}  // namespace
}  // namespace foreland::terrain
