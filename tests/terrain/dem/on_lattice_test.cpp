// Rasters of other grids on the lattice of a scene, and epochs that are made of them.
#include "terrain/dem/on_lattice.h"

#include <gtest/gtest.h>

#include <cmath>

#include "terrain/dem/open.h"
#include "terrain/epochs/read_epoch.h"
#include "terrain/pipeline/build.h"
#include "terrain/store/scene.h"
#include "terrain/store/verify.h"
#include "tests/support/files.h"
#include "tests/support/map_field.h"

namespace foreland::terrain {
namespace {

using test::Field;
using test::hills;

class OnLattice : public testing::Test {
 protected:
  std::string file(const std::string& name, const Field& f) const {
    return test::writeField((folder / name).string(), f);
  }
  std::unique_ptr<ElevationSource> openBase() const {
    auto source = openElevation({file("base.tif", base)}, open);
    EXPECT_TRUE(source.ok());
    return std::move(source).value();
  }
  std::unique_ptr<ElevationSource> laid(const std::string& name, const Field& f, const ElevationInfo& lattice) const {
    auto source = openOnLattice(file(name, f), open, lattice);
    EXPECT_TRUE(source.ok()) << (source.ok() ? "" : source.error().message);
    return std::move(source).value();
  }
  static std::vector<float> heightsOf(ElevationSource& source) {
    std::vector<float> heights(size_t{source.info().width} * source.info().height);
    EXPECT_TRUE(source.readRows(0, source.info().height, heights).ok());
    return heights;
  }
  // Of the first sample of a source, on the map.
  static glm::dvec2 cornerOf(const ElevationInfo& info) {
    return info.frame.map_origin_m - info.frame.anchor.x * info.frame.axis_x_m -
           info.frame.anchor.y * info.frame.axis_y_m;
  }

  test::TemporaryFolder folder;
  OpenOptions open{.is_fenced = false};
  Field base{.columns = 61, .rows = 53, .height = hills};
  // Of a third of the distance, and between the samples of the base.
  Field fine{.west = 500307, .north = 5149711, .step = 10, .columns = 66, .rows = 57, .height = hills};
};

TEST_F(OnLattice, KeepsTheBitsOfSamplesThatLieOnIt) {
  const auto lattice = openBase();
  Field part = base;
  part.west += 9 * 30, part.north -= 4 * 30, part.columns = 20, part.rows = 31;
  const auto as_it_is = openElevation({file("part.tif", part)}, open).value();
  ASSERT_TRUE(isOnLatticeOf(as_it_is->info(), lattice->info()));
  const auto source = laid("part.tif", part, lattice->info());
  const std::vector<float> expected = heightsOf(*as_it_is), all = heightsOf(*source);
  const glm::dvec2 first = (cornerOf(as_it_is->info()) - cornerOf(source->info())) / 30.0;
  const glm::uvec2 at(std::round(first.x), std::round(first.y));
  size_t known = 0;
  for (const float h : all) known += std::isnan(h) ? 0 : 1;
  EXPECT_EQ(known, expected.size());
  for (uint32_t y = 0; y < 31; ++y)
    for (uint32_t x = 0; x < 20; ++x)
      ASSERT_EQ(all[size_t{at.y + y} * source->info().width + at.x + x], expected[size_t{y} * 20 + x]);
}

TEST_F(OnLattice, InterpolatesRastersOfOtherGridsAndSystems) {
  const auto lattice = openBase();
  Field other = fine;
  other.crs = "EPSG:25832";  // within a metre of the base's, and the same to PROJ without grids
  for (const Field& f : {fine, other}) {
    EXPECT_FALSE(isOnLatticeOf(openElevation({file("fine.tif", f)}, open).value()->info(), lattice->info()));
    const auto source = laid("fine.tif", f, lattice->info());
    const ElevationInfo& info = source->info();
    EXPECT_TRUE(isOnLatticeOf(info, lattice->info()));
    const std::vector<float> heights = heightsOf(*source);
    size_t known = 0;
    for (uint32_t y = 0; y < info.height; ++y)
      for (uint32_t x = 0; x < info.width; ++x) {
        const glm::dvec2 at = cornerOf(info) + 30.0 * glm::dvec2(x, y);
        const float h = heights[size_t{y} * info.width + x];
        const bool is_inside =
            at.x >= fine.west && at.x <= fine.west + 650 && at.y <= fine.north && at.y >= fine.north - 560;
        if (&f == &fine) { EXPECT_EQ(std::isnan(h), !is_inside); }
        if (std::isnan(h)) continue;
        ++known;
        ASSERT_NEAR(h, hills(at.x, at.y), 0.05);
      }
    EXPECT_GT(known, 350u);
  }
}

TEST_F(OnLattice, RefusesWhatLiesBeyondIt) {
  const auto lattice = openBase();
  Field far = fine;
  far.west += 90'000;
  const auto refused = openOnLattice(file("far.tif", far), open, lattice->info());
  ASSERT_FALSE(refused.ok());
  EXPECT_NE(refused.error().message.find("far.tif: it lies beyond base.tif"), std::string::npos)
      << refused.error().message;
}

// The ground at each epoch is its file's, and elsewhere that of the scene.
TEST_F(OnLattice, MakesEpochsOfAnyResolutionOverInsets) {
  open.insets = {{file("inset.tif", fine), 0}};
  const auto ground = openBase();
  open.insets.clear();
  Field raised = fine, coarse = fine;
  raised.height = [](double x, double y) { return hills(x, y) + 25; };
  raised.west = 500'411, raised.north = 5'149'603, raised.step = 6.5;
  coarse.height = [](double x, double y) { return hills(x, y) - 40; };
  coarse.west = 500'395, coarse.north = 5'149'650, coarse.step = 45, coarse.columns = 9, coarse.rows = 8;
  const auto first = laid("raised.tif", raised, ground->info()), second = laid("coarse.tif", coarse, ground->info());
  const auto path = folder / "scene.fls";
  const auto report = buildScene(*ground, {.output = path,
                                           .height_quantum_m = 0.01,
                                           .threads = 2,
                                           .epochs = {{Time::seconds(1), "1", nullptr},
                                                      {Time::seconds(2), "2", first.get()},
                                                      {Time::seconds(3), "3", second.get()}}});
  ASSERT_TRUE(report.ok()) << report.error().message;
  const auto scene = Scene::open(path).value();
  EXPECT_TRUE(verifyScene(path, 2).value().sound());
  const glm::dvec2 corner = cornerOf(ground->info());
  const double step = ground->info().frame.axis_x_m.x;
  ASSERT_LT(step, 10.1);
  const auto offsetAt = [&](uint32_t epoch, double x, double y) {
    const auto n =
        proto::NodeId::at(static_cast<uint32_t>((x - corner.x) / step), static_cast<uint32_t>((y - corner.y) / step));
    return scene->epochs().offset(epoch, scene->grid(), n) * 0.01;
  };
  EXPECT_NEAR(offsetAt(1, 500'500, 5'149'500), 25, 0.5);
  EXPECT_EQ(offsetAt(1, 500'100, 5'149'900), 0);
  EXPECT_NEAR(offsetAt(2, 500'500, 5'149'500), -40, 1.5);
  EXPECT_NEAR(offsetAt(2, 500'700, 5'149'300), 25, 0.5) << "beyond the second the first goes on";
}

}  // namespace
}  // namespace foreland::terrain
