// Scenes of insets that are fine in places only: they are what whole ones are, their surface is as close to the sources
// as they state, and they cost what the sources hold and not what the lattice does.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "terrain/dem/compare_source.h"
#include "terrain/dem/open.h"
#include "terrain/imagery/verify_tiles.h"
#include "terrain/pipeline/build.h"
#include "terrain/store/scene.h"
#include "terrain/store/verify.h"
#include "tests/support/files.h"
#include "tests/support/map_field.h"

namespace foreland::terrain {
namespace {

using test::Field;
using test::hills;

class SparseInsets : public testing::Test {
 protected:
  std::string file(const std::string& name, const Field& f) const {
    return test::writeField((folder / name).string(), f);
  }

  std::shared_ptr<const Scene> scene(OpenOptions open, LatticeChoice lattice, unsigned threads = 2) const {
    open.is_fenced = false;
    open.lattice = lattice;
    const auto source = openElevation({file("base.tif", base)}, open);
    EXPECT_TRUE(source.ok()) << (source.ok() ? "" : source.error().message);
    if (!source.ok()) return nullptr;
    const auto report = buildScene(**source, {.output = path, .height_quantum_m = 0.01, .threads = threads});
    EXPECT_TRUE(report.ok()) << (report.ok() ? "" : report.error().message);
    const auto opened = Scene::open(path);
    EXPECT_TRUE(opened.ok());
    if (opened.ok()) {
      const TilesReport tiles = verifyTiles(**opened, 2);
      EXPECT_EQ(tiles.faults, 0u) << (tiles.first_faults.empty() ? "" : tiles.first_faults.front());
      EXPECT_EQ(tiles.layers.size(), 1u);
    }
    return opened.ok() ? *opened : nullptr;
  }

  // By how much a scene differs from the file of one of its inputs, where that counts alone.
  SourceDifference difference(const Scene& s, const SceneInput& input,
                              const std::vector<proto::LatticeWindow>& above) const {
    OpenOptions open;
    open.is_fenced = false;
    const proto::GridShape& shape = s.grid().shape();
    const LatticeHeights heights{
        {s.frame(), shape.samples_x, shape.samples_y, s.origin().crs_wkt, "scene"},
        [&](uint32_t x, uint32_t y) { return s.height(proto::NodeId::at(x, y)) * s.frame().height_quantum_m; }};
    const auto found = compareSource(folder / input.name, open, heights, [&](const std::string&) {
      return Result<SourceExtent>(SourceExtent{.above = above, .feather_m = input.feather_m});
    });
    EXPECT_TRUE(found.ok()) << found.error().message;
    return found.ok() && !found->empty() ? found->front() : SourceDifference{};
  }

  test::TemporaryFolder folder;
  std::filesystem::path path = folder / "scene.fls";
  Field base{.columns = 61, .rows = 53, .height = hills};
  Field fine{.west = 500300, .north = 5149700, .step = 7, .columns = 66, .rows = 57, .height = hills};
  // Finer, rougher, and over a corner of the first.
  Field finest{
      .west = 500603, .north = 5149511, .step = 2.5, .columns = 90, .rows = 70, .height = [](double x, double y) {
        return hills(x, y) + 3 * std::sin(x / 9) * std::cos(y / 7);
      }};
};

TEST_F(SparseInsets, AreWhatWholeOnesAre) {
  const OpenOptions open{.insets = {{file("fine.tif", fine), 0}}, .feather_m = 50};
  const auto whole = scene(open, LatticeChoice::kWhole);
  const auto sparse = scene(open, LatticeChoice::kSparse);
  ASSERT_TRUE(whole && sparse);
  EXPECT_FALSE(whole->isSparse());
  ASSERT_TRUE(sparse->isSparse());
  EXPECT_LT(sparse->records().size(), whole->records().size());
  EXPECT_TRUE(verifyScene(path, 2)->sound());
  const proto::GridShape& shape = whole->grid().shape();
  ASSERT_EQ(sparse->grid().shape().samples_x, shape.samples_x);
  for (uint32_t y = 0; y < shape.samples_y; ++y)
    for (uint32_t x = 0; x < shape.samples_x; ++x) {
      const proto::NodeId v = proto::NodeId::at(x, y);
      ASSERT_LE(std::abs(whole->height(v) - sparse->height(v)), 1) << x << ' ' << y;
    }
}

TEST_F(SparseInsets, AreAsCloseToSourcesAsTheyState) {
  for (const std::optional<double> residual_m : {std::optional<double>(), std::optional(1.0)}) {
    const OpenOptions open{.insets = {{file("finest.tif", finest), 1}, {file("fine.tif", fine), 0}},
                           .feather_m = 20,
                           .residual_m = residual_m};
    const auto s = scene(open, LatticeChoice::kSparse);
    ASSERT_TRUE(s && s->isSparse());
    EXPECT_TRUE(verifyScene(path, 2)->sound());
    ASSERT_EQ(s->inputs().size(), 3u);
    std::vector<proto::LatticeWindow> above;
    for (const SceneInput& input : s->inputs()) {
      const SourceDifference found = difference(*s, input, above);
      EXPECT_GT(found.compared, 100u) << input.name;
      EXPECT_LE(found.largest_m, input.residual_m + 1e-3) << input.name;
      EXPECT_LT(input.residual_m, 2) << input.name;
      above.push_back(input.window);
    }
  }
}

TEST_F(SparseInsets, TakeNoMoreHalvingsThanTheirOwn) {
  const OpenOptions both{.insets = {{file("finest.tif", finest), 1}, {file("fine.tif", fine), 0}}};
  const auto s = scene(both, LatticeChoice::kSparse);
  ASSERT_TRUE(s);
  const proto::GridTopology& grid = s->grid();
  ASSERT_EQ(grid.shape().samples_x, 60 * 16 + 1u);
  // In the north-west of the first, far from the second, 3.75 m are what is there.
  const auto isThere = [&](uint32_t x, uint32_t y) { return s->pages().hasPage(grid.slot(proto::NodeId::at(x, y))); };
  const uint32_t x = 16 * 13, y = 16 * 40;
  EXPECT_TRUE(isThere(x + 2, y + 2));
  EXPECT_FALSE(isThere(x + 1, y + 1));
  EXPECT_TRUE(isThere(16 * 22 + 1, 16 * 35 + 1)) << "under the second";
  EXPECT_FALSE(isThere(16 * 50 + 8, 16 * 5 + 8)) << "the base alone";
  // So are the tiles of relief: 248 texels a side.
  EXPECT_TRUE(s->tiles().bounds({0, 0, 16 * 24 / 248, 16 * 34 / 248})) << "under the second";
  EXPECT_FALSE(s->tiles().bounds({0, 0, 3, 0})) << "the base alone";
  EXPECT_TRUE(s->tiles().bounds({0, 2, 0, 0}));
}

TEST_F(SparseInsets, AreTheSameForAnyNumberOfThreads) {
  const OpenOptions open{.insets = {{file("fine.tif", fine), 0}}};
  std::vector<std::vector<char>> bytes;
  for (const unsigned threads : {1u, 4u}) {
    ASSERT_TRUE(scene(open, LatticeChoice::kSparse, threads));
    bytes.push_back(test::slurp(path));
  }
  EXPECT_EQ(bytes[0], bytes[1]);
}

// A lattice of 2^33 positions of some 20,000 samples.
TEST_F(SparseInsets, CostWhatTheirSamplesDo) {
  Field needle = finest;
  needle.step = 0.02;
  const auto s = scene({.insets = {{file("needle.tif", needle), 0}}}, LatticeChoice::kAuto);
  ASSERT_TRUE(s && s->isSparse());
  const proto::GridShape& shape = s->grid().shape();
  EXPECT_GT(uint64_t{shape.samples_x} * shape.samples_y, uint64_t{1} << 32);
  EXPECT_LT(s->records().size(), 1u << 20);
  EXPECT_LE(difference(*s, s->inputs().front(), {}).largest_m, s->inputs().front().residual_m + 1e-3);
}

TEST_F(SparseInsets, SmallLatticesStayWhole) {
  EXPECT_FALSE(scene({.insets = {{file("fine.tif", fine), 0}}}, LatticeChoice::kAuto)->isSparse());
}

}  // namespace
}  // namespace foreland::terrain
