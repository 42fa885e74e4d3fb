// Undulations against what cs2cs computes, and against a grid made here.
#include "terrain/geoid/geoid.h"

#include <gtest/gtest.h>
#include <proj.h>

#include <array>
#include <cmath>
#include <fstream>
#include <memory>
#include <vector>

#include "base/bytes.h"
#include "base/rng.h"
#include "terrain/geoid/earth_positions.h"
#include "terrain/geoid/reference_heights.h"
#include "tests/support/files.h"
#include "tests/support/seed.h"

namespace foreland::terrain {
namespace {

std::string wktOf(const std::string& crs) {
  const std::unique_ptr<PJ_CONTEXT, PJ_CONTEXT* (*)(PJ_CONTEXT*)> context(proj_context_create(), proj_context_destroy);
  const std::unique_ptr<PJ, PJ* (*)(PJ*)> made(proj_create(context.get(), crs.c_str()), proj_destroy);
  const char* text = made ? proj_as_wkt(context.get(), made.get(), PJ_WKT2_2019, nullptr) : nullptr;
  EXPECT_NE(text, nullptr) << crs;
  return text != nullptr ? text : "";
}

// Heights at points of height 0, as cs2cs transforms them.
class Cs2cs {
 public:
  Cs2cs(const char* from, const char* to)
      : context_(proj_context_create(), proj_context_destroy),
        way_(proj_create_crs_to_crs(context_.get(), from, to, nullptr), proj_destroy) {}
  double height(glm::dvec2 degrees) const {
    return proj_trans(way_.get(), PJ_FWD, proj_coord(degrees.y, degrees.x, 0, HUGE_VAL)).xyz.z;
  }

 private:
  std::unique_ptr<PJ_CONTEXT, PJ_CONTEXT* (*)(PJ_CONTEXT*)> context_;
  std::unique_ptr<PJ, PJ* (*)(PJ*)> way_;
};

double undulationAt(const Geoid& geoid, glm::dvec2 degrees) {
  double out = 0;
  geoid.undulations({&degrees, 1}, {&out, 1});
  return out;
}

TEST(Geoid, IsWhatCs2csComputes) {
  const auto geoid = Geoid::open("egm96");
  ASSERT_TRUE(geoid.ok()) << geoid.error().message;
  EXPECT_EQ((*geoid)->name(), "EGM96");
  const Cs2cs cs2cs("EPSG:4326+5773", "EPSG:4979");
  Rng rng(test::randomSeed());
  for (int i = 0; i < 1000; ++i) {
    const glm::dvec2 p(rng.uniform() * 360 - 180, rng.uniform() * 180 - 90);
    ASSERT_NEAR(undulationAt(**geoid, p), cs2cs.height(p), 1e-6) << p.x << ' ' << p.y;
  }
}

TEST(Geoid, IsBilinearBetweenItsLines) {
  const auto geoid = Geoid::open("egm96");
  ASSERT_TRUE(geoid.ok()) << geoid.error().message;
  const auto lines = (*geoid)->lines();
  ASSERT_TRUE(lines);
  EXPECT_NEAR(lines->step_degrees.x, 0.25, 1e-9);
  Rng rng(test::randomSeed());
  for (int i = 0; i < 200; ++i) {
    const glm::dvec2 corner =
        lines->first_degrees +
        glm::dvec2(static_cast<double>(rng.below(1438)), static_cast<double>(rng.below(718))) * lines->step_degrees;
    const glm::dvec2 share(rng.uniform(), rng.uniform());
    const auto at = [&](double x, double y) {
      return undulationAt(**geoid, corner + glm::dvec2(x, y) * lines->step_degrees);
    };
    const double south = at(0, 0) + share.x * (at(1, 0) - at(0, 0)), north = at(0, 1) + share.x * (at(1, 1) - at(0, 1));
    ASSERT_NEAR(at(share.x, share.y), south + share.y * (north - south), 1e-4);
  }
}

TEST(Geoid, TakesLongitudesThatAreATurnApart) {
  const auto geoid = Geoid::open("egm96");
  ASSERT_TRUE(geoid.ok());
  for (const double longitude : {0.1, 179.95, 200.0, 359.9})
    EXPECT_NEAR(undulationAt(**geoid, {longitude, 10}), undulationAt(**geoid, {longitude - 360, 10}), 1e-6);
}

// A grid of 3 x 3 that says 10, 11, ... over the Alps, as NOAA's GTX has it: big-endian, rows from the south.
std::string gridFile(const test::TemporaryFolder& folder, const std::string& name) {
  Bytes bytes;
  const auto put = [&](const auto& value) {
    const auto* at = reinterpret_cast<const uint8_t*>(&value);
    bytes.insert(bytes.end(), std::make_reverse_iterator(at + sizeof value), std::make_reverse_iterator(at));
  };
  for (const double v : {46.0, 8.0, 0.5, 0.5}) put(v);
  for (const int32_t v : {3, 3}) put(v);
  for (int i = 0; i < 9; ++i) put(static_cast<float>(10 + i));
  std::ofstream(folder / name, std::ios::binary)
      .write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  return (folder / name).string();
}

TEST(Geoid, IsReadOfAFile) {
  const test::TemporaryFolder folder;
  const auto geoid = Geoid::open(gridFile(folder, "my geoid.gtx"));
  ASSERT_TRUE(geoid.ok()) << geoid.error().message;
  EXPECT_EQ((*geoid)->name(), "my geoid.gtx");
  EXPECT_NEAR(undulationAt(**geoid, {8.5, 46.5}), 14, 1e-6);
  EXPECT_NEAR(undulationAt(**geoid, {8.25, 46}), 10.5, 1e-6);
  EXPECT_TRUE(std::isnan(undulationAt(**geoid, {20, 46}))) << "beyond the grid";
}

TEST(Geoid, ThatIsNotThereIsNamedWithWhereItComesFrom) {
  const auto expectRefused = [](const std::string& choice, const std::vector<std::string>& words) {
    const auto geoid = Geoid::open(choice);
    ASSERT_FALSE(geoid.ok()) << choice;
    for (const std::string& word : words)
      EXPECT_NE(geoid.error().message.find(word), std::string::npos) << word << " is not in " << geoid.error().message;
  };
  const test::TemporaryFolder folder;
  std::ofstream(folder / "noise.gtx") << "this is no grid";
  expectRefused((folder / "none.gtx").string(), {"none.gtx", "no such file", "egm96"});
  expectRefused("egm1996", {"egm1996", "egm96"});
  expectRefused((folder / "noise.gtx").string(), {"noise.gtx", "not a grid of undulations"});
  expectRefused(folder.path().string(), {folder.path().string(), "no such file"});
  if (const auto fine = Geoid::open("egm2008"); !fine.ok())
    expectRefused("egm2008", {"EGM2008", "us_nga_egm08_25.tif", "projsync --file"});
}

TEST(Geoid, OfACompoundReferenceSystemIsTheOneItNames) {
  const auto named = Geoid::ofReferenceSystem(wktOf("EPSG:32632+5773"), {7, 45, 9, 47});
  ASSERT_TRUE(named.ok()) << named.error().message;
  EXPECT_EQ((*named)->name(), "EGM96");
  const auto missing = Geoid::ofReferenceSystem(wktOf("EPSG:26910+5703"), {-123, 46, -122, 47});
  if (missing.ok()) GTEST_SKIP() << "grids of NAVD88 are here";
  for (const char* word : {"NAVD88 height", "us_noaa", ".tif", "projsync --file"})
    EXPECT_NE(missing.error().message.find(word), std::string::npos)
        << word << " is not in " << missing.error().message;
}

TEST(HeightsOf, AreStatedByCompoundAndThreeDimensionalSystemsAlone) {
  EXPECT_EQ(heightsOf(wktOf("EPSG:4326")).kind, StatedHeights::kNone);
  EXPECT_EQ(heightsOf(wktOf("EPSG:32632")).kind, StatedHeights::kNone);
  EXPECT_EQ(heightsOf("").kind, StatedHeights::kNone);
  EXPECT_EQ(heightsOf("no reference system").kind, StatedHeights::kNone);
  EXPECT_EQ(heightsOf(wktOf("EPSG:4979")).kind, StatedHeights::kEllipsoid);
  EXPECT_EQ(heightsOf(wktOf("EPSG:32632+5773")).kind, StatedHeights::kVerticalSystem);
  EXPECT_EQ(heightsOf(wktOf("EPSG:32632+5773")).name, "EGM96 height");
}

TEST(EarthPositions, AreThoseOfTheMap) {
  const auto positions = EarthPositions::of(wktOf("EPSG:32632+5773"));
  ASSERT_TRUE(positions.ok()) << positions.error().message;
  std::array<glm::dvec2, 2> at{{{500000, 0}, {500000, 5149999.999}}};
  (*positions)->toDegrees(at);
  EXPECT_NEAR(at[0].x, 9, 1e-9);
  EXPECT_NEAR(at[0].y, 0, 1e-9);
  EXPECT_NEAR(at[1].x, 9, 1e-9);
  EXPECT_NEAR(at[1].y, 46.5, 0.01);
}

TEST(EarthPositions, AreNoneOnAnotherBody) {
  const auto mars = EarthPositions::of(wktOf("ESRI:104905"));
  ASSERT_FALSE(mars.ok());
  EXPECT_NE(mars.error().message.find("no transformation to WGS84"), std::string::npos) << mars.error().message;
  EXPECT_FALSE(EarthPositions::of("LOCAL_CS[\"a building site\",UNIT[\"metre\",1]]").ok());
}

}  // namespace
}  // namespace foreland::terrain
