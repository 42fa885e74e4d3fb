// Pictures on a scene's lattice: colours land where they should, whatever the file, and what cannot be meant is refused
// by name.
#include "terrain/dem/pictures/open_pictures.h"

#include <gdal.h>
#include <gtest/gtest.h>
#include <ogr_srs_api.h>

#include <array>
#include <cmath>
#include <fstream>
#include <functional>
#include <optional>

#include "terrain/dem/formats/gdal_raster.h"
#include "terrain/dem/open.h"
#include "terrain/dem/pictures/write_picture.h"
#include "tests/support/data.h"
#include "tests/support/files.h"

namespace foreland::terrain {
namespace {

namespace fs = std::filesystem;
constexpr double kDegree = 0.017453292519943295;

std::string wktOf(int epsg) {
  OGRSpatialReferenceH crs = OSRNewSpatialReference(nullptr);
  EXPECT_EQ(OSRImportFromEPSG(crs, epsg), OGRERR_NONE);
  char* text = nullptr;
  OSRExportToWkt(crs, &text);
  const std::string wkt = text;
  VSIFree(text);
  OSRDestroySpatialReference(crs);
  return wkt;
}

struct PictureSpec {
  int width = 100, height = 80, bands = 3;
  std::optional<std::array<double, 6>> transform{};
  int epsg = 0;  // 0: none
  std::function<uint8_t(int band, int x, int y)> value = [](int, int, int) { return uint8_t{0}; };
  GDALDataType type = GDT_Byte;
  bool palette = false, alpha = false;
};

class Pictures : public testing::Test {
 protected:
  test::TemporaryFolder folder;

  void SetUp() override { registerGdalDrivers(); }

  fs::path write(const std::string& name, const PictureSpec& spec) {
    const fs::path path = folder / name;
    GDALDatasetH file =
        GDALCreate(GDALGetDriverByName("GTiff"), path.c_str(), spec.width, spec.height, spec.bands, spec.type, nullptr);
    if (spec.transform) {
      auto t = *spec.transform;
      GDALSetGeoTransform(file, t.data());
    }
    if (spec.epsg) GDALSetProjection(file, wktOf(spec.epsg).c_str());
    if (spec.palette) {
      GDALColorTableH table = GDALCreateColorTable(GPI_RGB);
      for (int i = 0; i < 256; ++i) {
        const GDALColorEntry entry{static_cast<short>(255 - i), 7, static_cast<short>(i), 255};
        GDALSetColorEntry(table, i, &entry);
      }
      GDALSetRasterColorTable(GDALGetRasterBand(file, 1), table);
      GDALDestroyColorTable(table);
    }
    if (spec.alpha) GDALSetRasterColorInterpretation(GDALGetRasterBand(file, spec.bands), GCI_AlphaBand);
    for (int b = 1; b <= spec.bands; ++b)
      for (int y = 0; y < spec.height; ++y) {
        std::vector<uint8_t> row;
        for (int x = 0; x < spec.width; ++x) row.push_back(spec.value(b, x, y));
        EXPECT_EQ(GDALRasterIO(GDALGetRasterBand(file, b), GF_Write, 0, y, spec.width, 1, row.data(), spec.width, 1,
                               GDT_Byte, 0, 0),
                  CE_None);
      }
    GDALClose(file);
    return path;
  }

  // 41 x 31 samples of 10 m in UTM zone 32, the south-western one at (500000, 5150000).
  static PictureLattice utm() {
    PictureLattice lattice{.frame = {}, .crs_wkt = wktOf(32632), .samples_x = 41, .samples_y = 31};
    lattice.frame.axis_x_m = {10, 0}, lattice.frame.axis_y_m = {0, 10};
    lattice.frame.anchor = {20, 15};
    lattice.frame.map_origin_m = {500200, 5150150};
    return lattice;
  }
  // 0.001 degrees apart from 46.5 north, 9 east.
  static PictureLattice degrees(double longitude_deg = 9) {
    PictureLattice lattice{.frame = {}, .crs_wkt = wktOf(4326), .samples_x = 41, .samples_y = 31};
    lattice.frame.kind = proto::FrameKind::kGeographic;
    lattice.frame.latitude0_rad = 46.5 * kDegree, lattice.frame.longitude0_rad = longitude_deg * kDegree;
    lattice.frame.latitude_step_rad = lattice.frame.longitude_step_rad = 0.001 * kDegree;
    return lattice;
  }
  // A picture of the lattice's samples, a pixel each.
  PictureSpec over(const PictureLattice& lattice) {
    PictureSpec spec{.width = 41, .height = 31};
    if (lattice.frame.kind == proto::FrameKind::kGeographic)
      spec.transform = {9 - 0.0005, 0.001, 0, 46.5 + 0.0305, 0, -0.001}, spec.epsg = 4326;
    else
      spec.transform = {499995, 10, 0, 5150305, 0, -10}, spec.epsg = 32632;
    return spec;
  }

  static std::vector<Rgba> readAll(PictureSource& source) {
    const PictureInfo& info = source.info();
    std::vector<Rgba> texels(size_t{info.width} * info.height);
    const Status status = source.read({0, 0, info.width, info.height}, texels);
    EXPECT_TRUE(status.ok()) << status.error().message;
    return texels;
  }
  void expectRefusal(const fs::path& path, const PictureLattice& lattice, const std::string& words) {
    const auto source = openPictures({path}, lattice);
    ASSERT_FALSE(source.ok());
    EXPECT_NE(source.error().message.find(path.filename().string()), std::string::npos) << source.error().message;
    EXPECT_NE(source.error().message.find(words), std::string::npos) << source.error().message;
  }
};

TEST_F(Pictures, OnTheSamplesLatticeKeepTheirPixelsWithTheSouthFirst) {
  for (const PictureLattice& lattice : {utm(), degrees()}) {
    PictureSpec spec = over(lattice);
    spec.value = [](int band, int x, int y) { return static_cast<uint8_t>(band * 40 + 2 * x + 3 * y); };
    auto source = openPictures({write("same.tif", spec)}, lattice);
    ASSERT_TRUE(source.ok()) << source.error().message;
    EXPECT_EQ((*source)->info().texel, 1);
    EXPECT_EQ((*source)->info().width, 41u);
    EXPECT_EQ((*source)->info().height, 31u);
    EXPECT_EQ((*source)->info().origin, glm::dvec2(-0.5, -0.5));
    EXPECT_TRUE((*source)->info().notes.empty());
    const auto texels = readAll(**source);
    for (int y = 0; y < 31; ++y)
      for (int x = 0; x < 41; ++x) {
        const auto v = [&](int band) { return static_cast<uint8_t>(band * 40 + 2 * x + 3 * (30 - y)); };
        ASSERT_EQ(texels[static_cast<size_t>(y * 41 + x)], (Rgba{v(1), v(2), v(3), 255})) << x << ' ' << y;
      }
  }
}

// Colours by longitude and latitude, on a lattice in another reference system.
TEST_F(Pictures, InAnotherReferenceSystemLandWhereTheyBelong) {
  PictureSpec spec{.width = 400, .height = 400};
  spec.transform = {8.99, 0.0001, 0, 46.53, 0, -0.0001}, spec.epsg = 4326;
  spec.value = [](int band, int x, int y) { return static_cast<uint8_t>(band == 1 ? x / 2 : band == 2 ? y / 2 : 99); };
  const PictureLattice lattice = utm();
  auto source = openPictures({write("degrees.tif", spec)}, lattice);
  ASSERT_TRUE(source.ok()) << source.error().message;
  const PictureInfo& info = (*source)->info();
  EXPECT_EQ(info.texel, 0.5);  // 7.7 m of longitude over 10 m
  const auto texels = readAll(**source);
  OGRSpatialReferenceH from = OSRNewSpatialReference(lattice.crs_wkt.c_str()), to = OSRNewSpatialReference(nullptr);
  OSRImportFromEPSG(to, 4326);
  for (OGRSpatialReferenceH crs : {from, to}) OSRSetAxisMappingStrategy(crs, OAMS_TRADITIONAL_GIS_ORDER);
  OGRCoordinateTransformationH transformation = OCTNewCoordinateTransformation(from, to);
  for (uint32_t y = 0; y < info.height; y += 3)
    for (uint32_t x = 0; x < info.width; x += 3) {
      const double lx = info.origin.x + (x + 0.5) * info.texel, ly = info.origin.y + (y + 0.5) * info.texel;
      double east = 500000 + 10 * lx, north = 5150000 + 10 * ly;
      ASSERT_TRUE(OCTTransform(transformation, 1, &east, &north, nullptr));
      const Rgba& t = texels[size_t{y} * info.width + x];
      ASSERT_NEAR(t.red, (east - 8.99) / 0.0002 - 0.25, 1) << x << ' ' << y;
      ASSERT_NEAR(t.green, (46.53 - north) / 0.0002 - 0.25, 1) << x << ' ' << y;
      ASSERT_EQ(t.alpha, 255);
    }
  OCTDestroyCoordinateTransformation(transformation);
  OSRDestroySpatialReference(from);
  OSRDestroySpatialReference(to);
}

TEST_F(Pictures, AnyWindowHasTheTexelsOfTheWhole) {
  PictureSpec spec = over(utm());
  spec.transform = {499995, 3.1, 0.4, 5150305, 0.2, -3.3}, spec.width = 140, spec.height = 100;
  spec.value = [](int band, int x, int y) { return static_cast<uint8_t>((band * 7 + x) * (y + 3)); };
  auto source = openPictures({write("turned.tif", spec)}, utm());
  ASSERT_TRUE(source.ok()) << source.error().message;
  const auto whole = readAll(**source);
  const PictureWindow w{13, 20, 50, 17};
  std::vector<Rgba> part(size_t{w.width} * w.height);
  ASSERT_TRUE((*source)->read(w, part).ok());
  // GDAL approximates positions to an eighth of a pixel, by windows.
  double sum = 0;
  for (uint32_t y = 0; y < w.height; ++y)
    for (uint32_t x = 0; x < w.width; ++x)
      sum += std::abs(part[y * w.width + x].red - whole[size_t{w.y + y} * (*source)->info().width + w.x + x].red);
  EXPECT_LT(sum / static_cast<double>(part.size()), 2);
}

TEST_F(Pictures, GreyPaletteAndAlphaBecomeColours) {
  const PictureLattice lattice = utm();
  const auto middle = [&](const PictureSpec& spec) {
    auto source = openPictures({write("kind.tif", spec)}, lattice);
    EXPECT_TRUE(source.ok()) << source.error().message;
    return readAll(**source)[15 * 41 + 20];
  };
  PictureSpec spec = over(lattice);
  spec.value = [](int band, int, int) { return static_cast<uint8_t>(band == 1 ? 200 : 20); };
  spec.bands = 1;
  EXPECT_EQ(middle(spec), (Rgba{200, 200, 200, 255}));
  spec.palette = true;
  EXPECT_EQ(middle(spec), (Rgba{55, 7, 200, 255}));
  spec.palette = false, spec.bands = 2, spec.alpha = true;
  spec.value = [](int band, int, int) { return static_cast<uint8_t>(band == 1 ? 200 : 0); };
  EXPECT_LT(middle(spec).alpha, 128);
  spec.bands = 4;
  EXPECT_LT(middle(spec).alpha, 128);
  spec.value = [](int band, int, int) { return static_cast<uint8_t>(10 * band + 215); };
  EXPECT_EQ(middle(spec), (Rgba{225, 235, 245, 255}));
}

// Infrared that is tagged as alpha: dark over water, and nowhere opaque.
TEST_F(Pictures, WhatIsNoAlphaIsLeftOutWithANoteUnlessItIsChosen) {
  PictureLattice lattice = utm();
  PictureSpec spec = over(lattice);
  spec.bands = 4, spec.alpha = true;
  const auto infrared = [](int x) { return x < 20 ? 0 : 120 + 3 * (x - 20); };
  const auto mask = [](int x) { return x < 20 ? 0 : x == 20 ? 120 : 255; };
  const auto alphaOf = [&](AlphaChoice choice, const auto& band4, size_t notes) {
    spec.value = [&](int band, int x, int) { return static_cast<uint8_t>(band < 4 ? 50 * band : band4(x)); };
    lattice.alpha = choice;
    auto source = openPictures({write("nir.tif", spec)}, lattice);
    EXPECT_TRUE(source.ok()) << source.error().message;
    EXPECT_EQ((*source)->info().notes.size(), notes);
    for (const std::string& note : (*source)->info().notes) {
      EXPECT_NE(note.find("nir.tif: its band 4 is tagged as alpha"), std::string::npos) << note;
      EXPECT_NE(note.find("--imagery-alpha use"), std::string::npos) << note;
    }
    const auto texels = readAll(**source);
    return std::array{texels[15 * 41 + 5].alpha, texels[15 * 41 + 38].alpha};
  };
  using Alphas = std::array<uint8_t, 2>;
  EXPECT_EQ(alphaOf(AlphaChoice::kAuto, infrared, 1), (Alphas{255, 255}));
  EXPECT_EQ(alphaOf(AlphaChoice::kUse, infrared, 0), (Alphas{0, 174}));
  EXPECT_EQ(alphaOf(AlphaChoice::kIgnore, infrared, 0), (Alphas{255, 255}));
  EXPECT_EQ(alphaOf(AlphaChoice::kAuto, mask, 0), (Alphas{0, 255}));
  EXPECT_EQ(alphaOf(AlphaChoice::kIgnore, mask, 0), (Alphas{255, 255}));
}

TEST_F(Pictures, TheFinestShowsAndOfEqualsTheFirst) {
  const PictureLattice lattice = utm();
  PictureSpec coarse = over(lattice), fine = over(lattice);
  coarse.value = [](int, int, int) { return uint8_t{10}; };
  fine.value = [](int, int, int) { return uint8_t{90}; };
  fine.transform = {500095, 2.5, 0, 5150205, 0, -2.5}, fine.width = fine.height = 40;
  PictureSpec other = coarse;
  other.value = [](int, int, int) { return uint8_t{30}; };
  const auto a = write("coarse.tif", coarse), b = write("fine.tif", fine), c = write("other.tif", other);
  for (const std::vector<fs::path>& files : {std::vector{a, b, c}, std::vector{b, a, c}}) {
    auto source = openPictures(files, lattice);
    ASSERT_TRUE(source.ok());
    EXPECT_EQ((*source)->info().texel, 0.25);
    const auto texels = readAll(**source);
    const auto at = [&](double x, double y) {
      return texels[static_cast<size_t>((y + 0.5) * 4) * (*source)->info().width + static_cast<size_t>((x + 0.5) * 4)];
    };
    EXPECT_EQ(at(15, 15).red, 90);
    EXPECT_EQ(at(30, 25).red, 10);
  }
}

TEST_F(Pictures, WithoutGeoreferenceLieOverTheWholeSceneWithANote) {
  PictureSpec spec{.width = 82, .height = 62};
  spec.value = [](int band, int x, int y) { return static_cast<uint8_t>(band == 1 ? x : y); };
  for (const PictureLattice& lattice : {utm(), degrees()}) {
    auto source = openPictures({write("plain.tif", spec)}, lattice);
    ASSERT_TRUE(source.ok()) << source.error().message;
    ASSERT_EQ((*source)->info().notes.size(), 1u);
    EXPECT_NE((*source)->info().notes[0].find("plain.tif: it has no georeference"), std::string::npos);
    EXPECT_EQ((*source)->info().texel, 0.5);
    const auto texels = readAll(**source);
    EXPECT_EQ(texels[0].red, 0);
    EXPECT_EQ(texels[0].green, 61);
    EXPECT_EQ(texels.back().red, 81);
    EXPECT_EQ(texels.back().green, 0);
  }
}

TEST_F(Pictures, ScenesBeyondTheEndOfAPicturesLongitudesSeeItsOtherEnd) {
  PictureSpec world{.width = 720, .height = 360};
  world.transform = {-180, 0.5, 0, 90, 0, -0.5}, world.epsg = 4326;
  world.value = [](int, int x, int) { return static_cast<uint8_t>(x / 3); };
  const auto path = write("world.tif", world);
  for (const double longitude : {-150.0, 210.0, 179.98}) {
    PictureLattice lattice = degrees(longitude);
    auto source = openPictures({path}, lattice);
    ASSERT_TRUE(source.ok()) << source.error().message;
    EXPECT_EQ((*source)->info().texel, 256);
    lattice.frame.longitude_step_rad *= 20;  // 0.8 degrees
    source = openPictures({path}, lattice);
    ASSERT_TRUE(source.ok());
    for (const Rgba& t : readAll(**source)) {
      EXPECT_EQ(t.alpha, 255);
      EXPECT_TRUE(longitude == 179.98 || std::abs(t.red - 20) <= 1) << int{t.red};
    }
  }
}

TEST_F(Pictures, WhatCannotBeMeantIsRefusedByName) {
  const PictureLattice lattice = utm();
  PictureSpec spec = over(lattice);
  spec.bands = 30;
  expectRefusal(write("thirty.tif", spec), lattice, "30 bands");
  spec = over(lattice), spec.type = GDT_UInt16;
  expectRefusal(write("deep.tif", spec), lattice, "not 8 bits");
  spec = over(lattice), spec.transform = {700000, 10, 0, 5150305, 0, -10};
  expectRefusal(write("elsewhere.tif", spec), lattice, "beyond the scene");
  expectRefusal(folder / "missing.tif", lattice, "");
  std::ofstream(folder / "text.tif") << "not a picture";
  expectRefusal(folder / "text.tif", lattice, "not a picture");
  PictureLattice plain = lattice;
  plain.crs_wkt.clear();
  expectRefusal(write("placed.tif", over(lattice)), plain, "the elevation has none");
  PictureLattice flat = lattice;
  flat.crs_wkt = wktOf(4326);
  const auto flattened = openPictures({write("flat.tif", over(lattice))}, flat);
  ASSERT_FALSE(flattened.ok());
  EXPECT_NE(flattened.error().message.find("--frame planar"), std::string::npos);
}

TEST_F(Pictures, ACutFileIsAnErrorThatNamesIt) {
  PictureSpec spec = over(utm());
  spec.transform = {499995, 1, 0, 5150305, 0, -1}, spec.width = 410, spec.height = 310;
  spec.value = [](int, int x, int y) { return static_cast<uint8_t>(x * y); };
  const auto path = write("cut.tif", spec);
  fs::resize_file(path, fs::file_size(path) * 6 / 10);
  auto source = openPictures({path}, utm());
  if (!source.ok()) return;  // found at once
  const PictureInfo& info = (*source)->info();
  std::vector<Rgba> texels(size_t{info.width} * info.height);
  const Status status = (*source)->read({0, 0, info.width, info.height}, texels);
  ASSERT_FALSE(status.ok());
  EXPECT_NE(status.error().message.find("cut.tif"), std::string::npos);
}

TEST_F(Pictures, ThatWereWrittenAreReadAtTheSamePositions) {
  for (const PictureLattice& lattice : {utm(), degrees()}) {
    const fs::path path = folder / "written.tif";
    fs::remove(path);
    auto writer = createPicture(path, lattice, 2);
    ASSERT_TRUE(writer.ok()) << writer.error().message;
    std::vector<std::array<uint8_t, 3>> rows;
    for (int y = 0; y < 62; ++y)
      for (int x = 0; x < 82; ++x)
        rows.push_back({static_cast<uint8_t>(2 * x), static_cast<uint8_t>(3 * y), static_cast<uint8_t>(90)});
    ASSERT_TRUE((*writer)->writeRows(20, std::span(rows).first(20 * 82)).ok());
    EXPECT_FALSE(fs::exists(path));
    ASSERT_TRUE((*writer)->writeRows(42, std::span(rows).subspan(20 * 82)).ok());
    ASSERT_TRUE((*writer)->finish().ok());
    auto source = openPictures({path}, lattice);
    ASSERT_TRUE(source.ok()) << source.error().message;
    EXPECT_TRUE((*source)->info().notes.empty());
    EXPECT_EQ((*source)->info().texel, 0.5);
    const auto texels = readAll(**source);
    for (size_t i = 0; i < texels.size(); ++i) {
      const auto& wanted = rows[(61 - i / 82) * 82 + i % 82];
      ASSERT_NEAR(texels[i].red, wanted[0], 10) << i;
      ASSERT_NEAR(texels[i].green, wanted[1], 10) << i;
    }
  }
}

TEST_F(Pictures, PlacesThatCannotBeWrittenAreRefused) {
  EXPECT_FALSE(createPicture(folder / "a.png", utm(), 2).ok());
  EXPECT_FALSE(createPicture(folder / "nowhere/a.tif", utm(), 2).ok());
  PictureLattice large = utm();
  large.samples_x = 1u << 20;
  EXPECT_FALSE(createPicture(folder / "a.tif", large, 1024).ok());
  EXPECT_TRUE(fs::is_empty(folder.path()));
}

TEST_F(Pictures, RealOnesFitTheirElevation) {
  FORELAND_DATA_OR_SKIP(elevation, "dem/misc/craterlake-elev-16bit-30m.tif");
  FORELAND_DATA_OR_SKIP(picture, "imagery/craterlake-imagery-30m.tif");
  const auto dem = openElevation({elevation}, {});
  ASSERT_TRUE(dem.ok());
  const ElevationInfo& info = (*dem)->info();
  auto source = openPictures({picture}, {info.frame, info.crs_wkt, info.width, info.height});
  ASSERT_TRUE(source.ok()) << source.error().message;
  EXPECT_EQ((*source)->info().width, 429u);
  EXPECT_EQ((*source)->info().height, 279u);
}

}  // namespace
}  // namespace foreland::terrain
