// `foreland viewshed` as people run it, and beside gdal_viewshed where that is installed.
#include <gdal.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdlib>
#include <vector>

#include "tests/apps/expect_refusal.h"
#include "tests/support/data.h"
#include "tests/support/scene.h"

namespace foreland::test {
namespace {

struct Raster {
  int width = 0, height = 0;
  std::array<double, 6> transform{};
  double no_data = -1;
  bool has_reference = false;
  std::vector<uint8_t> cells;  // from the north

  uint8_t at(int x, int y) const {
    return cells[static_cast<size_t>(y) * static_cast<size_t>(width) + static_cast<size_t>(x)];
  }
};

Raster readRaster(const std::string& path) {
  GDALAllRegister();
  Raster raster;
  GDALDatasetH dataset = GDALOpen(path.c_str(), GA_ReadOnly);
  if (dataset == nullptr) return raster;
  raster.width = GDALGetRasterXSize(dataset), raster.height = GDALGetRasterYSize(dataset);
  raster.cells.resize(static_cast<size_t>(raster.width) * static_cast<size_t>(raster.height));
  GDALRasterBandH band = GDALGetRasterBand(dataset, 1);
  GDALGetGeoTransform(dataset, raster.transform.data());
  raster.no_data = GDALGetRasterNoDataValue(band, nullptr);
  raster.has_reference = GDALGetSpatialRef(dataset) != nullptr;
  const CPLErr failed = GDALRasterIO(band, GF_Read, 0, 0, raster.width, raster.height, raster.cells.data(),
                                     raster.width, raster.height, GDT_Byte, 0, 0);
  EXPECT_EQ(failed, CE_None);
  GDALClose(dataset);
  return raster;
}

// A scene file of 65 x 65 samples, 10 m apart, whose map begins at (-320, -320).
std::string writeScene(const TemporaryFolder& folder, const HeightFunction& ground = hills(3)) {
  const std::string path = folder / "land.fls";
  FormulaSource source(65, 65, ground);
  CHECK_TRUE(terrain::buildScene(source, {.output = path, .height_quantum_m = 0.1}).ok());
  return path;
}

TEST(ViewshedProgram, WritesWhatIsSeenWhereItIs) {
  const TemporaryFolder folder;
  // A wall along x = 0 with level ground on both sides.
  const std::string scene = writeScene(folder, [](uint32_t x, uint32_t) { return x == 32 ? 50.0 : 0.0; });
  const std::string file = folder / "seen.tif";
  const ProgramResult result = runProgram("viewshed", {scene, "--from", "-100,0,2", "--radius", "200", "-o", file});
  EXPECT_EQ(result.exit_code, 0) << result.output;
  EXPECT_NE(result.output.find("seen.tif: "), std::string::npos) << result.output;
  const Raster raster = readRaster(file);
  ASSERT_EQ(raster.width, 41);
  ASSERT_EQ(raster.height, 41);
  EXPECT_EQ(raster.transform, (std::array<double, 6>{-305, 10, 0, 205, 0, -10}));
  EXPECT_EQ(raster.no_data, 1);
  for (int y = 0; y < 41; ++y)
    for (int x = 0; x < 41; ++x) {
      const double map_x = -300 + 10 * x, map_y = 200 - 10 * y;
      const bool is_near = std::hypot(map_x + 100, map_y) <= 200;
      ASSERT_EQ(raster.at(x, y), !is_near ? 1 : map_x <= 0 ? 255 : 0) << map_x << ", " << map_y;
    }
}

TEST(ViewshedProgram, HasCellsOfTheSizeAskedFor) {
  const TemporaryFolder folder;
  const std::string scene = writeScene(folder), file = folder / "seen.tif";
  const ProgramResult result =
      runProgram("viewshed", {scene, "--from", "3,-7,2", "--radius", "100", "--cell", "25", "-o", file});
  EXPECT_EQ(result.exit_code, 0) << result.output;
  const Raster raster = readRaster(file);
  EXPECT_EQ(raster.transform[1], 25);
  EXPECT_EQ(raster.transform[5], -25);
  EXPECT_EQ(raster.width, 8);
  EXPECT_EQ(raster.height, 8);
}

TEST(ViewshedProgram, RefusesWhatMakesNoSense) {
  const TemporaryFolder folder;
  const std::string scene = writeScene(folder), file = folder / "seen.tif";
  const auto refuses = [&](const std::vector<std::string>& more, const std::string& why) {
    std::vector<std::string> arguments{scene};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const ProgramResult result = runProgram("viewshed", arguments);
    EXPECT_EQ(result.exit_code, 2) << result.output;
    EXPECT_NE(result.output.find(why), std::string::npos) << result.output;
    EXPECT_FALSE(std::filesystem::exists(file));
  };
  refuses({"--from", "0,0", "-o", file}, "--from '0,0': write LAT,LON,HEIGHT");
  refuses({"--from", "0,nan,3", "-o", file}, "write LAT,LON,HEIGHT");
  refuses({"--from", "9000,0,3", "-o", file}, "beyond the data");
  refuses({"--from", "0,0,-3", "-o", file}, "under the ground");
  refuses({"--from", "0,0,3", "-o", folder / "seen.png"}, "must end in .tif");
  refuses({"--from", "0,0,3", "-o", file, "--radius", "1e300"}, "--radius");
  refuses({"--from", "0,0,3", "-o", file, "--cell", "0"}, "--cell");
  refuses({"--from", "0,0,3", "-o", file, "--cell", "0.001"}, "cells; ask for a smaller radius");
  refuses({"--from", "0,0,3", "-o", file, "--date", "2001-02-03"}, "does not change in time");
}

bool isInstalled(const std::string& program) {
  return std::system(("command -v " + program + " > /dev/null 2>&1").c_str()) == 0;
}

// gdal_viewshed walks from the observer outward and takes what hides a cell from its neighbours, so it is nearly right.
// Close below an observer it calls cells hidden that touch the observer's own, so this one stands on a mast.
TEST(ViewshedProgram, SeesWhatGdalSees) {
  FORELAND_DATA_OR_SKIP(elevation, "dem/msh/msh_base_utm10_10m.tif");
  if (!isInstalled("gdal_viewshed")) GTEST_SKIP() << "gdal_viewshed is not installed (gdal-bin)";
  const TemporaryFolder folder;
  const std::string scene = folder / "helens.fls", ours = folder / "ours.tif", gdals = folder / "gdals.tif";
  ASSERT_EQ(runProgram("build", {elevation.string(), "-o", scene}).exit_code, 0);
  const std::string x = "561059.99850089", y = "5118629.9888518";
  const ProgramResult result = runProgram("viewshed", {scene, "--from", x + "," + y + ",30", "-o", ours});
  ASSERT_EQ(result.exit_code, 0) << result.output;
  const std::string command = "gdal_viewshed -q -oz 30 -tz 0 -md 10000 -cc 0.8571428571 -ox " + x + " -oy " + y + " '" +
                              elevation.string() + "' '" + gdals + "'";
  ASSERT_EQ(std::system(command.c_str()), 0) << command;
  const Raster a = readRaster(ours), b = readRaster(gdals);
  ASSERT_EQ(a.width, b.width);
  ASSERT_EQ(a.height, b.height);
  EXPECT_TRUE(a.has_reference);
  for (size_t i = 0; i < 6; ++i) EXPECT_NEAR(a.transform[i], b.transform[i], 1e-6) << i;
  size_t cells = 0, differing = 0, far_from_edges = 0;
  for (int row = 1; row + 1 < a.height; ++row)
    for (int column = 1; column + 1 < a.width; ++column) {
      if (a.at(column, row) == 1) continue;
      ++cells;
      if (a.at(column, row) == b.at(column, row)) continue;
      ++differing;
      bool is_at_edge = false;
      for (int j = -1; j <= 1; ++j)
        for (int i = -1; i <= 1; ++i) is_at_edge |= a.at(column + i, row + j) != a.at(column, row);
      far_from_edges += is_at_edge ? 0 : 1;
    }
  std::printf("%zu cells, %zu differ, %zu of these not at an edge\n", cells, differing, far_from_edges);
  EXPECT_GT(cells, 2'000'000u);
  EXPECT_LT(static_cast<double>(differing), 0.005 * static_cast<double>(cells));
  EXPECT_LT(static_cast<double>(far_from_edges), 0.0005 * static_cast<double>(cells));
}

}  // namespace
}  // namespace foreland::test
