// Heights above one surface brought to another: against what cs2cs computes, there and back, merged without a cliff,
// and left as they are where nobody asks.
#include <cpl_conv.h>
#include <gdal.h>
#include <gtest/gtest.h>
#include <ogr_srs_api.h>
#include <proj.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "base/rng.h"
#include "terrain/dem/formats/gdal_raster.h"
#include "terrain/dem/open.h"
#include "tests/support/data.h"
#include "tests/support/files.h"
#include "tests/support/seed.h"

namespace foreland::terrain {
namespace {

constexpr int kCount = 48;  // samples a side

double hill(double column, double row) { return 600 + 80 * std::sin(0.2 * column) + 50 * std::cos(0.15 * row); }

// As cs2cs transforms points from one reference system to another; x before y, height in metres.
class Cs2cs {
 public:
  Cs2cs(const std::string& from, const std::string& to)
      : context_(proj_context_create(), proj_context_destroy), way_(nullptr, proj_destroy) {
    const std::unique_ptr<PJ, PJ* (*)(PJ*)> way(
        proj_create_crs_to_crs(context_.get(), from.c_str(), to.c_str(), nullptr), proj_destroy);
    way_.reset(proj_normalize_for_visualization(context_.get(), way.get()));
  }
  double height(double x, double y, double height) const {
    return proj_trans(way_.get(), PJ_FWD, proj_coord(x, y, height, HUGE_VAL)).xyz.z;
  }

 private:
  std::unique_ptr<PJ_CONTEXT, PJ_CONTEXT* (*)(PJ_CONTEXT*)> context_;
  std::unique_ptr<PJ, PJ* (*)(PJ*)> way_;
};

struct File {
  std::string crs = "EPSG:4326";
  double west = 8.1, north = 46.9, step = 0.01;  // of the first sample's middle
  int first_column = 0, columns = kCount;
  std::function<double(double x, double y, double height)> height = [](double, double, double h) { return h; };
};

std::string write(const std::string& path, const File& f) {
  registerGdalDrivers();
  GDALDatasetH dataset =
      GDALCreate(GDALGetDriverByName("GTiff"), path.c_str(), f.columns, kCount, 1, GDT_Float32, nullptr);
  OGRSpatialReferenceH crs = OSRNewSpatialReference(nullptr);
  EXPECT_EQ(OSRSetFromUserInput(crs, f.crs.c_str()), OGRERR_NONE);
  OSRSetAxisMappingStrategy(crs, OAMS_TRADITIONAL_GIS_ORDER);
  std::array<double, 6> t{f.west + (f.first_column - 0.5) * f.step, f.step, 0, f.north + 0.5 * f.step, 0, -f.step};
  GDALSetGeoTransform(dataset, t.data());
  GDALSetSpatialRef(dataset, crs);
  OSRDestroySpatialReference(crs);
  std::vector<float> heights;
  for (int row = 0; row < kCount; ++row)
    for (int column = f.first_column; column < f.first_column + f.columns; ++column)
      heights.push_back(
          static_cast<float>(f.height(f.west + column * f.step, f.north - row * f.step, hill(column, row))));
  EXPECT_EQ(GDALRasterIO(GDALGetRasterBand(dataset, 1), GF_Write, 0, 0, f.columns, kCount, heights.data(), f.columns,
                         kCount, GDT_Float32, 0, 0),
            CE_None);
  GDALClose(dataset);
  return path;
}

Result<std::unique_ptr<ElevationSource>> opened(const std::vector<std::filesystem::path>& inputs, OpenOptions options) {
  options.is_fenced = false;
  return openElevation(inputs, options);
}

std::vector<float> heightsOf(ElevationSource& source) {
  std::vector<float> out(size_t{source.info().width} * source.info().height);
  const Status read = source.readRows(0, source.info().height, out);
  EXPECT_TRUE(read.ok()) << (read.ok() ? "" : read.error().message);
  return out;
}

// Rows of a source go north.
void expectHills(ElevationSource& source, double within_m) {
  const std::vector<float> got = heightsOf(source);
  const uint32_t width = source.info().width, height = source.info().height;
  for (uint32_t y = 0; y < height; ++y)
    for (uint32_t x = 0; x < width; ++x)
      ASSERT_NEAR(got[size_t{y} * width + x], hill(x, height - 1 - y), within_m) << x << ' ' << y;
}

bool says(const std::vector<std::string>& sentences, const std::string& words) {
  return std::ranges::any_of(sentences, [&](const std::string& s) { return s.find(words) != std::string::npos; });
}

class Vertical : public testing::Test {
 protected:
  test::TemporaryFolder folder;
  std::string file(const std::string& name, const File& f = {}) const { return write((folder / name).string(), f); }
};

TEST_F(Vertical, HeightsAreThoseOfCs2cs) {
  struct Map {
    File file;
    std::string with_geoid, above_ellipsoid;
  };
  for (const Map& map :
       {Map{{}, "EPSG:4326+5773", "EPSG:4979"},
        Map{{.crs = "EPSG:32610", .west = 560000, .north = 5120000, .step = 300}, "EPSG:32610+5773", "EPSG:4979"}}) {
    const auto source = opened({file("sea.tif", map.file)}, {.vertical = "egm96", .scene_vertical = "ellipsoid"});
    ASSERT_TRUE(source.ok()) << source.error().message;
    const std::vector<float> got = heightsOf(**source);
    const Cs2cs cs2cs(map.with_geoid, map.above_ellipsoid);
    Rng rng(test::randomSeed());
    for (int i = 0; i < 100; ++i) {
      const auto column = static_cast<int>(rng.below(kCount)), row = static_cast<int>(rng.below(kCount));
      const double wanted =
          cs2cs.height(map.file.west + column * map.file.step, map.file.north - row * map.file.step, hill(column, row));
      ASSERT_NEAR(got[static_cast<size_t>((kCount - 1 - row) * kCount + column)], wanted, 0.001);
    }
  }
}

TEST_F(Vertical, ThereAndBackIsWhereItWas) {
  const Cs2cs up("EPSG:4326+5773", "EPSG:4979");
  const std::string above_ellipsoid =
      file("ellipsoid.tif", {.height = [&](double x, double y, double h) { return up.height(x, y, h); }});
  const auto source = opened({above_ellipsoid}, {.vertical = "ellipsoid", .scene_vertical = "egm96"});
  ASSERT_TRUE(source.ok()) << source.error().message;
  expectHills(**source, 0.001);
}

TEST_F(Vertical, InputsOfTwoDatumsMergeWithoutACliff) {
  const Cs2cs up("EPSG:4326+5773", "EPSG:4979");
  const std::string west = file("west.tif", {.columns = kCount / 2});
  const std::string east =
      file("east.tif", {.first_column = kCount / 2, .columns = kCount / 2, .height = [&](double x, double y, double h) {
                          return up.height(x, y, h);
                        }});
  const auto cliff = opened({west, east}, {});
  ASSERT_TRUE(cliff.ok());
  const std::vector<float> as_they_are = heightsOf(**cliff);
  EXPECT_GT(as_they_are[kCount - 1] - hill(kCount - 1, kCount - 1), 40) << "half of it is above the ellipsoid";
  const auto merged = opened({west, east}, {.vertical = "egm96", .vertical_of = {{east, "ellipsoid"}}});
  ASSERT_TRUE(merged.ok()) << merged.error().message;
  expectHills(**merged, 0.001);
  EXPECT_EQ((*merged)->info().vertical.name, "EGM96") << "the first input's";
  ASSERT_EQ((*merged)->info().inputs.size(), 2u);
  EXPECT_EQ((*merged)->info().inputs[1].name, "east.tif");
  EXPECT_EQ((*merged)->info().inputs[1].vertical, "ellipsoid");
  EXPECT_EQ((*merged)->info().inputs[1].window, (proto::LatticeWindow{kCount / 2, 0, kCount / 2, kCount}));
}

TEST_F(Vertical, ReferenceSystemsSayItThemselves) {
  const Cs2cs up("EPSG:4326+5773", "EPSG:4979");
  const std::string west = file("west.tif", {.crs = "EPSG:4326+5773", .columns = kCount / 2});
  const std::string east =
      file("east.tif", {.crs = "EPSG:4979",
                        .first_column = kCount / 2,
                        .columns = kCount / 2,
                        .height = [&](double x, double y, double h) { return up.height(x, y, h); }});
  const auto merged = opened({west, east}, {});
  ASSERT_TRUE(merged.ok()) << merged.error().message;
  expectHills(**merged, 0.001);
  EXPECT_EQ((*merged)->info().vertical.name, "EGM96");
  EXPECT_TRUE(says((*merged)->info().notes, "east.tif: its heights are above ellipsoid, and were brought to EGM96"));
}

TEST_F(Vertical, InputsWhoseMapsDifferInHeightsAloneAreOneMosaic) {
  const File map{.crs = "EPSG:32632+5773", .west = 400000, .north = 5150000, .step = 300, .columns = kCount / 2};
  File other = map;
  other.crs = "EPSG:32632", other.first_column = kCount / 2;
  const auto merged = opened({file("west.tif", map), file("east.tif", other)}, {.vertical = "egm96"});
  ASSERT_TRUE(merged.ok()) << merged.error().message;
  expectHills(**merged, 0.001);
}

TEST_F(Vertical, WithoutAQuestionNothingChanges) {
  const std::string stated = file("stated.tif", {.crs = "EPSG:4326+5773"}), plain = file("plain.tif");
  for (const std::vector<std::filesystem::path>& inputs :
       {std::vector<std::filesystem::path>{plain}, {stated}, {stated, plain}}) {
    const auto source = opened(inputs, {});
    ASSERT_TRUE(source.ok()) << source.error().message;
    expectHills(**source, 1e-4);
    EXPECT_EQ((*source)->info().vertical.zero_surface, proto::ZeroSurface::kUnstated);
    EXPECT_TRUE((*source)->info().inputs.empty());
    EXPECT_TRUE((*source)->info().notes.empty()) << (*source)->info().notes.front();
  }
}

TEST_F(Vertical, ThatIsTheScenesLeavesEveryBitOfTheHeights) {
  const std::string plain = file("plain.tif");
  const auto before = opened({plain}, {}), after = opened({plain}, {.vertical = "egm96"});
  ASSERT_TRUE(before.ok() && after.ok());
  EXPECT_EQ(heightsOf(**before), heightsOf(**after));
  EXPECT_EQ((*after)->info().vertical.geoid, "EGM96");
}

TEST_F(Vertical, UndulationsAreWithinWhatTheGridSays) {
  for (const File& map : {File{}, File{.crs = "EPSG:32610", .west = 560000, .north = 5120000, .step = 300},
                          File{.crs = "EPSG:26710", .west = 560000, .north = 5120000, .step = 3000}}) {
    const auto source = opened({file("map.tif", map)}, {.vertical = "egm96"});
    ASSERT_TRUE(source.ok()) << source.error().message;
    const proto::UndulationGrid& grid = (*source)->info().vertical.undulations;
    ASSERT_FALSE(grid.isEmpty());
    EXPECT_LE(grid.max_error_m, 0.002);
    const Cs2cs cs2cs(map.crs + "+5773", "EPSG:4979");
    Rng rng(test::randomSeed());
    for (int i = 0; i < 500; ++i) {
      const double x = rng.uniform(0, kCount - 1), y = rng.uniform(0, kCount - 1);
      const double wanted = cs2cs.height(map.west + x * map.step, map.north - (kCount - 1 - y) * map.step, 0);
      ASSERT_NEAR(grid.at({x, y}), wanted, 2 * grid.max_error_m + 1e-4) << map.crs << ' ' << x << ' ' << y;
    }
  }
}

TEST_F(Vertical, WhatCannotBeBroughtIsNamed) {
  const auto expectRefused = [](const Result<std::unique_ptr<ElevationSource>>& result,
                                const std::vector<std::string>& words) {
    ASSERT_FALSE(result.ok());
    for (const std::string& word : words)
      EXPECT_NE(result.error().message.find(word), std::string::npos)
          << word << " is not in " << result.error().message;
  };
  const std::string plain = file("plain.tif");
  expectRefused(opened({plain}, {.vertical = (folder / "none.gtx").string()}),
                {"plain.tif", "none.gtx", "no such file"});
  expectRefused(opened({plain}, {.vertical = "file"}), {"plain.tif", "does not say", "egm96"});
  expectRefused(opened({plain}, {.vertical = "egm96", .scene_vertical = "sea"}), {"--scene-vertical", "sea"});
  expectRefused(opened({plain}, {.vertical = file("steep.tif", {.west = 7, .north = 48, .step = 0.1})}),
                {"steep.tif", "no grid of undulations"});
  const std::string mars = file("mars.tif", {.crs = "ESRI:104905"});
  expectRefused(opened({mars}, {.vertical = "egm96", .scene_vertical = "ellipsoid"}),
                {"mars.tif", "no transformation to WGS84"});
  const auto there = opened({mars}, {.vertical = "egm96"});
  ASSERT_TRUE(there.ok()) << "no height need move";
  EXPECT_TRUE(says((*there)->info().notes, "are not known")) << "so it has no undulations";
}

TEST_F(Vertical, AMissingGridOfAReferenceSystemIsNamedWhereItIsNeeded) {
  const File map{.crs = "EPSG:26910+5703", .west = 560000, .north = 5120000, .step = 30};
  const auto alone = opened({file("navd.tif", map)}, {.vertical = "file"});
  ASSERT_TRUE(alone.ok()) << alone.error().message;
  EXPECT_EQ((*alone)->info().vertical.name, "NAVD88 height");
  const auto moved = opened({(folder / "navd.tif").string()}, {.vertical = "file", .scene_vertical = "ellipsoid"});
  if (moved.ok()) GTEST_SKIP() << "grids of NAVD88 are here";
  for (const char* word : {"navd.tif", "NAVD88 height", "us_noaa", "projsync --file"})
    EXPECT_NE(moved.error().message.find(word), std::string::npos) << word << " is not in " << moved.error().message;
}

TEST_F(Vertical, InputsThatDisagreeAreDoubtedWithTheLikelyCause) {
  const auto warningsWith = [&](const std::function<double(double, double, double)>& height) {
    const auto source = opened({file("first.tif"), file("second.tif", {.height = height})}, {});
    EXPECT_TRUE(source.ok());
    heightsOf(**source);
    return (*source)->warnings();
  };
  EXPECT_TRUE(warningsWith([](double, double, double h) { return h + 60; }).empty());
  const auto feet = warningsWith([](double, double, double h) { return h / 0.3048; });
  ASSERT_EQ(feet.size(), 1u);
  for (const char* word : {"first.tif", "second.tif", "the second is likely in feet"})
    EXPECT_TRUE(says(feet, word)) << word << " is not in " << feet.front();
  EXPECT_TRUE(says(warningsWith([](double, double, double h) { return h * 0.3048; }), "the first is likely in feet"));
  EXPECT_TRUE(says(warningsWith([](double, double, double h) { return h * 100; }), "100 times as large"));
  EXPECT_TRUE(says(warningsWith([](double, double, double h) { return h - 105; }), "another vertical datum"));
  EXPECT_TRUE(says(warningsWith([](double, double, double h) { return h + 5000; }), "another zero"));
  EXPECT_TRUE(says(warningsWith([](double, double, double h) { return 4000 - 2 * h; }), "not of the same ground"));
}

// Ten points over each: h less H is what cs2cs says by the same grid.
TEST_F(Vertical, OfRealDataIsWithinTwoCentimetresOfCs2cs) {
  FORELAND_DATA_OR_SKIP(alps, "dem/srtm/N46E008.tif");
  FORELAND_DATA_OR_SKIP(helens, "dem/msh/SainteHelens.dem");
  for (const auto& [path, crs] : {std::pair(alps, "EPSG:4326"), std::pair(helens, "EPSG:26710")}) {
    const auto sea = opened({path}, {.vertical = "egm96"});
    const auto ellipsoid = opened({path}, {.vertical = "egm96", .scene_vertical = "ellipsoid"});
    ASSERT_TRUE(sea.ok() && ellipsoid.ok());
    const std::vector<float> above_sea = heightsOf(**sea), above_ellipsoid = heightsOf(**ellipsoid);
    const ElevationInfo& info = (*sea)->info();
    const proto::Frame& f = info.frame;
    const Cs2cs cs2cs(std::string(crs) + "+5773", "EPSG:4979");
    Rng rng(test::randomSeed());
    for (int points = 0; points < 10;) {
      const auto x = static_cast<uint32_t>(rng.below(info.width)), y = static_cast<uint32_t>(rng.below(info.height));
      const double sea_m = above_sea[size_t{y} * info.width + x],
                   ellipsoid_m = above_ellipsoid[size_t{y} * info.width + x];
      if (std::isnan(sea_m)) continue;
      constexpr double kDegrees = 57.29577951308232;
      const glm::dvec2 at =
          f.kind == proto::FrameKind::kPlanar
              ? f.map_origin_m + (x - f.anchor.x) * f.axis_x_m + (y - f.anchor.y) * f.axis_y_m
              : glm::dvec2(f.longitude0_rad + x * f.longitude_step_rad, f.latitude0_rad + y * f.latitude_step_rad) *
                    kDegrees;
      const double wanted = cs2cs.height(at.x, at.y, 0);
      EXPECT_NEAR(ellipsoid_m - sea_m, wanted, 0.02) << path << ' ' << x << ' ' << y;
      EXPECT_NEAR(info.vertical.undulations.at({x, y}), wanted, 0.02) << path << ' ' << x << ' ' << y;
      ++points;
    }
  }
}

}  // namespace
}  // namespace foreland::terrain
