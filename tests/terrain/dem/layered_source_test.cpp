// Rasters of other grids over a base: nothing changes where they tell the same, priorities, voids and feathers, the
// base as bisection draws it, and residuals against an oracle of its own (PROJ and bilinear sums, no code of
// terrain/dem).
#include <gdal.h>
#include <gtest/gtest.h>
#include <ogr_srs_api.h>
#include <proj.h>

#include <array>
#include <cmath>
#include <glm/vec2.hpp>
#include <limits>
#include <memory>
#include <numbers>
#include <string>
#include <vector>

#include "proto/topology/grid.h"
#include "terrain/dem/compare_source.h"
#include "terrain/dem/formats/gdal_raster.h"
#include "terrain/dem/open.h"
#include "terrain/pipeline/build.h"
#include "tests/support/files.h"
#include "tests/support/map_field.h"

namespace foreland::terrain {
namespace {

constexpr float kNone = std::numeric_limits<float>::quiet_NaN();
constexpr double kDegree = std::numbers::pi / 180;

using test::Field;
using test::HeightAt;
using test::hills;
using test::writeField;

// What a source says, with its heights.
struct Ground {
  ElevationInfo info;
  std::vector<float> metres;
  std::vector<std::string> warnings;

  float at(uint32_t x, uint32_t y) const { return metres[size_t{y} * info.width + x]; }
  double bilinear(glm::dvec2 p) const {
    const auto x = static_cast<uint32_t>(std::min(p.x, info.width - 2.0)),
               y = static_cast<uint32_t>(std::min(p.y, info.height - 2.0));
    const double u = p.x - x, v = p.y - y;
    return (1 - u) * (1 - v) * at(x, y) + u * (1 - v) * at(x + 1, y) + (1 - u) * v * at(x, y + 1) +
           u * v * at(x + 1, y + 1);
  }
};

class Insets : public testing::Test {
 protected:
  std::string file(const std::string& name, const Field& f) const { return writeField((folder / name).string(), f); }

  static Result<std::unique_ptr<ElevationSource>> opened(const std::vector<std::filesystem::path>& inputs,
                                                         OpenOptions options) {
    options.is_fenced = false;
    return openElevation(inputs, options);
  }
  static Ground ground(const std::vector<std::filesystem::path>& inputs, const OpenOptions& options = {}) {
    const auto source = opened(inputs, options);
    EXPECT_TRUE(source.ok()) << (source.ok() ? "" : source.error().message);
    if (!source.ok()) return {};
    Ground out{(*source)->info(), {}, {}};
    out.metres.resize(size_t{out.info.width} * out.info.height);
    EXPECT_TRUE((*source)->readRows(0, out.info.height, out.metres).ok());
    out.warnings = (*source)->warnings();
    return out;
  }
  static void expectRefused(const std::vector<std::filesystem::path>& inputs, const OpenOptions& options,
                            const std::vector<std::string>& words) {
    const auto result = opened(inputs, options);
    ASSERT_FALSE(result.ok());
    for (const std::string& word : words)
      EXPECT_NE(result.error().message.find(word), std::string::npos)
          << word << " is not in " << result.error().message;
  }

  test::TemporaryFolder folder;
  Field base_field{.height = hills};
  // In the middle of the base, three times as fine.
  Field fine{.west = 500300, .north = 5149700, .step = 10, .columns = 46, .rows = 40, .height = hills};
};

HeightAt flat(double height_m) {
  return [=](double, double) { return height_m; };
}

bool says(const std::vector<std::string>& sentences, const std::string& words) {
  return std::ranges::any_of(sentences, [&](const std::string& s) { return s.find(words) != std::string::npos; });
}

TEST_F(Insets, EqualToTheBaseChangeNothing) {
  const std::string base = file("base.tif", base_field);
  Field part = base_field;
  part.west += 5 * part.step, part.north -= 7 * part.step, part.columns = 20, part.rows = 15;
  const Ground plain = ground({base}), same = ground({base}, {.insets = {{base, 0}, {file("part.tif", part), 0}}});
  EXPECT_EQ(plain.metres, same.metres);
  EXPECT_EQ(plain.info.frame, same.info.frame);
  ASSERT_EQ(same.info.inputs.size(), 3u);
  for (const ElevationInput& input : same.info.inputs)
    if (!input.is_on_lattice) { EXPECT_EQ(input.residual_m, 0) << input.name; }
}

TEST_F(Insets, TheBaseIsDrawnAsBisectionDrawsIt) {
  Field far = fine;  // in a corner, so that the rest is the base's
  far.west = base_field.west, far.north = base_field.north, far.columns = far.rows = 8, far.step = 7.5;
  const Ground g = ground({file("base.tif", base_field)}, {.insets = {{file("fine.tif", far), 0}}});
  ASSERT_EQ(g.info.width, 161u);
  const auto grid = proto::GridTopology::create(proto::GridTopology::shapeFor(g.info.width, g.info.height));
  ASSERT_TRUE(grid.ok());
  uint64_t nodes = 0;
  for (uint32_t y = 0; y < g.info.height - 24; ++y)  // the inset is in the north
    for (uint32_t x = 0; x < g.info.width; ++x) {
      if (x % 4 == 0 && y % 4 == 0) continue;  // the base's own
      const auto [a, b] = grid->endpoints(proto::NodeId::at(x, y));
      const double middle = 0.5 * (double{g.at(a.x(), a.y())} + g.at(b.x(), b.y()));
      ASSERT_NEAR(g.at(x, y), middle, 2e-4) << x << ' ' << y;
      ++nodes;
    }
  EXPECT_GT(nodes, 10000u);
}

TEST_F(Insets, ShowByPriorityAndThenInTheirOrder) {
  const std::string base = file("base.tif", {.height = flat(0)});
  Field f = fine;
  f.height = flat(10);
  const std::string first = file("first.tif", f);
  f.height = flat(20), f.step = 9;
  const std::string second = file("second.tif", f);
  f.height = flat(30), f.step = 11;
  const std::string third = file("third.tif", f);
  const auto middleOf = [&](int a, int b, int c) {
    const Ground g = ground({base}, {.insets = {{first, a}, {second, b}, {third, c}}, .feather_m = 0});
    return g.at(g.info.width / 2 - 16, g.info.height / 2 + 16);
  };
  EXPECT_EQ(middleOf(0, 0, 0), 10) << "of equals the first";
  EXPECT_EQ(middleOf(0, 1, 1), 20);
  EXPECT_EQ(middleOf(-1, -2, -1), 10);
  EXPECT_EQ(middleOf(0, 0, 7), 30);
}

// Insets of one grid that lie apart are laid over the base one by one, as what is between them is nobody's; those that
// touch are one, in whatever order they are named.
TEST_F(Insets, AreOneWhereTheyTouch) {
  const std::string base = file("base.tif", base_field);
  Field west = fine, between = fine, east = fine;
  west.columns = east.columns = 12, between.columns = 10;
  between.west += 12 * fine.step, east.west += 22 * fine.step;
  const std::string w = file("west.tif", west), b = file("between.tif", between), e = file("east.tif", east);
  const auto laid = [&](std::vector<std::string> names) {
    OpenOptions options;
    for (const std::string& name : names) options.insets.push_back({name, 0});
    return std::ranges::count_if(ground({base}, options).info.notes, [](const std::string& note) {
      return note.find("laid over the base") != std::string::npos;
    });
  };
  EXPECT_EQ(laid({w, e}), 2);
  EXPECT_EQ(laid({w, b}), 1);
  EXPECT_EQ(laid({w, e, b}), 1);
  EXPECT_EQ(laid({e, b, w}), 1);
}

TEST_F(Insets, VoidsShowWhatIsBelow) {
  Field upper = fine, lower = fine;
  lower.height = flat(700), lower.step = 9, lower.columns = 52, lower.rows = 45;
  upper.height = [&](double x, double) { return x > fine.west + 200 ? double{kNone} : 800.0; };
  const Ground g = ground({file("base.tif", {.height = flat(600)})},
                          {.insets = {{file("upper.tif", upper), 0}, {file("lower.tif", lower), 0}}, .feather_m = 0});
  const double spacing_m = g.info.frame.axis_x_m.x;
  const auto at = [&](double x_m, double y_m) {
    return g.at(static_cast<uint32_t>(x_m / spacing_m), g.info.height - 1 - static_cast<uint32_t>(y_m / spacing_m));
  };
  EXPECT_EQ(at(400, 450), 800);
  EXPECT_EQ(at(650, 450), 700) << "the upper one is void";
  EXPECT_EQ(at(1000, 450), 600);
}

TEST_F(Insets, FeathersLeaveNoCliff) {
  constexpr double kDifference_m = 40, kWidth_m = 120;
  Field raised = fine;
  raised.height = flat(600 + kDifference_m);
  const Ground g = ground({file("base.tif", {.height = flat(600)})},
                          {.insets = {{file("raised.tif", raised), 0}}, .feather_m = kWidth_m});
  const double samples = kWidth_m / g.info.frame.axis_x_m.x;
  double largest_m = 0, highest_m = 0;
  for (uint32_t y = 0; y + 1 < g.info.height; ++y)
    for (uint32_t x = 0; x + 1 < g.info.width; ++x) {
      largest_m = std::max(
          {largest_m, std::fabs(double{g.at(x + 1, y)} - g.at(x, y)), std::fabs(double{g.at(x, y + 1)} - g.at(x, y))});
      highest_m = std::max(highest_m, double{g.at(x, y)});
    }
  // Smoothstep is at most 1.5 times as steep as a ramp; what is bilinear between the inset's samples is no steeper.
  EXPECT_LE(largest_m, 1.5 * kDifference_m / samples + 1e-3);
  EXPECT_GT(largest_m, 0.5 * kDifference_m / samples);
  EXPECT_FLOAT_EQ(static_cast<float>(highest_m), 600 + kDifference_m);
}

// From one map to another, x before y.
class Way {
 public:
  Way(const std::string& from, const std::string& to)
      : context_(proj_context_create(), proj_context_destroy), way_(nullptr, proj_destroy) {
    const std::unique_ptr<PJ, PJ* (*)(PJ*)> way(
        proj_create_crs_to_crs(context_.get(), from.c_str(), to.c_str(), nullptr), proj_destroy);
    way_.reset(proj_normalize_for_visualization(context_.get(), way.get()));
  }
  glm::dvec2 operator()(double x, double y) const {
    const PJ_COORD at = proj_trans(way_.get(), PJ_FWD, proj_coord(x, y, 0, HUGE_VAL));
    return {at.xy.x, at.xy.y};
  }

 private:
  std::unique_ptr<PJ_CONTEXT, PJ_CONTEXT* (*)(PJ_CONTEXT*)> context_;
  std::unique_ptr<PJ, PJ* (*)(PJ*)> way_;
};

// By how much the ground differs from a survey in UTM at most, at its samples further than `edge` samples from its
// border.
double differenceInDegrees(const Ground& g, const Field& survey, int edge) {
  const Way to_degrees(survey.crs, "EPSG:4326");
  const proto::Frame& f = g.info.frame;
  double largest_m = 0;
  for (int row = edge; row < survey.rows - edge; ++row)
    for (int column = edge; column < survey.columns - edge; ++column) {
      const double x = survey.west + column * survey.step, y = survey.north - row * survey.step;
      const glm::dvec2 degrees = to_degrees(x, y);
      const glm::dvec2 at((degrees.x * kDegree - f.longitude0_rad) / f.longitude_step_rad,
                          (degrees.y * kDegree - f.latitude0_rad) / f.latitude_step_rad);
      largest_m = std::max(largest_m, std::fabs(g.bilinear(at) - static_cast<float>(survey.height(x, y))));
    }
  return largest_m;
}

class InsetsInDegrees : public Insets {
 protected:
  Field degrees{.crs = "EPSG:4326",
                .west = 8.99,
                .north = 46.51,
                .step = 1 / 1200.0,
                .columns = 40,
                .rows = 30,
                .height = flat(600)};
  Field survey{.west = 500300, .north = 5149700, .step = 10, .columns = 120, .rows = 100, .height = hills};
};

// Rounding alone puts them beside the lattice's, and a neighbour of a void, or the last of a row, would be lost.
TEST_F(InsetsInDegrees, SamplesOnTheLatticeKeepTheirHeights) {
  constexpr int kColumn = 7, kRow = 3;  // of the base, that the part begins at
  Field part = degrees;
  part.west += kColumn * part.step, part.north -= kRow * part.step, part.columns = 21, part.rows = 17;
  int sample = 0;
  part.height = [&](double, double) { return ++sample == 100 ? double{kNone} : 700 + 0.37 * sample; };
  const std::string inset = file("part.tif", part);
  const Ground g = ground({file("base.tif", degrees)}, {.insets = {{inset, 0}}, .feather_m = 0});
  for (int row = 0; row < part.rows; ++row)
    for (int column = 0; column < part.columns; ++column) {
      const int number = row * part.columns + column + 1;
      const auto x = static_cast<uint32_t>(kColumn + column);
      const auto y = static_cast<uint32_t>(degrees.rows - 1 - kRow - row);
      ASSERT_EQ(g.at(x, y), number == 100 ? 600.f : static_cast<float>(700 + 0.37 * number)) << column << ' ' << row;
    }
}

TEST_F(InsetsInDegrees, StatedResidualsHoldAgainstAnOracle) {
  const std::string base = file("base.tif", degrees), fine_file = file("survey.tif", survey);
  for (const std::optional<double> residual_m : {std::optional<double>(), std::optional(4.0), std::optional(0.3)}) {
    const Ground g = ground({base}, {.insets = {{fine_file, 0}}, .feather_m = 50, .residual_m = residual_m});
    ASSERT_EQ(g.info.inputs.size(), 2u);
    const double stated_m = g.info.inputs.front().residual_m,
                 found_m = differenceInDegrees(
                     g, survey, 5 + static_cast<int>(2 * g.info.frame.latitude_step_rad * 6371000 / survey.step) + 2);
    EXPECT_GE(stated_m + 1e-4, found_m);
    EXPECT_GT(found_m, 0.2 * stated_m) << "it is not stated idly";
    EXPECT_LT(stated_m, residual_m.value_or(1.0));
  }
}

TEST_F(InsetsInDegrees, TheLatticeIsAsFineAsTheResidualAsks) {
  const std::string base = file("base.tif", degrees), fine_file = file("survey.tif", survey);
  const auto widthFor = [&](std::optional<double> residual_m) {
    return ground({base}, {.insets = {{fine_file, 0}}, .residual_m = residual_m}).info.width;
  };
  EXPECT_EQ(widthFor(std::nullopt), 39 * 8 + 1u) << "92 and 64 m become 8 and 8 m";
  EXPECT_LT(widthFor(8), 39 * 8 + 1u);
  EXPECT_GT(widthFor(0.01), 39 * 8 + 1u);
}

TEST_F(InsetsInDegrees, SourcesAreAsCloseAsIsStatedAndNotWhereOthersCount) {
  const std::string base = file("base.tif", degrees), fine_file = file("survey.tif", survey);
  const Ground g = ground({base}, {.insets = {{fine_file, 0}}, .feather_m = 50});
  const LatticeHeights heights{{g.info.frame, g.info.width, g.info.height, g.info.crs_wkt, "scene"},
                               [&](uint32_t x, uint32_t y) { return double{g.at(x, y)}; }};
  OpenOptions open;
  open.is_fenced = false;
  for (const ElevationInput& input : g.info.inputs) {
    SourceExtent extent{.feather_m = input.feather_m};
    if (input.name == "base.tif") extent.above.push_back(g.info.inputs.front().window);
    const auto found = compareSource(folder / input.name, open, heights,
                                     [&](const std::string&) -> Result<SourceExtent> { return extent; });
    ASSERT_TRUE(found.ok()) << found.error().message;
    EXPECT_GT(found->front().compared, 500u);
    EXPECT_LE(found->front().largest_m, (input.is_on_lattice ? 0 : input.residual_m) + 1e-3) << input.name;
  }
}

TEST_F(Insets, InputsOfDifferentGridsAreLaidOut) {
  Field east = base_field;
  east.west += 35 * east.step + 11, east.north -= 4;
  east.step = 15;
  const Ground g = ground({file("base.tif", base_field), file("east.tif", east)});
  EXPECT_EQ(g.info.width, 2 * (35 + 21) + 1u) << "halved, and widened to the east";
  EXPECT_EQ(g.info.frame.map_origin_m.x + (0 - g.info.frame.anchor.x) * g.info.frame.axis_x_m.x, base_field.west);
  for (uint32_t y = 0; y < 60; y += 7)
    for (uint32_t x = 0; x < g.info.width - 3; x += 5) {
      const double map_x = base_field.west + 15.0 * x, map_y = base_field.north - 15.0 * (g.info.height - 1 - y);
      if (map_x > east.west + 20 && map_y > east.north - 15.0 * 30 && map_y < east.north - 20) {
        ASSERT_NEAR(g.at(x, y), hills(map_x, map_y), 1.0) << x << ' ' << y;
      }
    }
}

TEST_F(Insets, CoarserThanTheBaseFillItsVoidsOnly) {
  Field holed = base_field, coarse = base_field;
  holed.height = [&](double x, double y) {
    return std::hypot(x - 500600, y - 5149400) < 130 ? double{kNone} : hills(x, y);
  };
  coarse.step = 75, coarse.columns = 17, coarse.rows = 15, coarse.height = flat(900);
  const std::string base = file("base.tif", holed);
  const Ground plain = ground({base}),
               g = ground({base}, {.insets = {{file("coarse.tif", coarse), 0}}, .feather_m = 60});
  ASSERT_EQ(g.info.width, plain.info.width);
  EXPECT_EQ(g.at(20, 16), 900);
  EXPECT_EQ(g.at(5, 5), plain.at(5, 5));
  EXPECT_TRUE(says(g.info.notes, "it shows only where that has no data"));
}

TEST_F(Insets, ScenesAreTheSameForAnyNumberOfThreads) {
  const std::string base = file("base.tif", base_field), inset = file("fine.tif", fine);
  std::vector<std::vector<char>> bytes;
  for (const unsigned threads : {1u, 4u}) {
    const auto source = opened({base}, {.insets = {{inset, 0}}});
    ASSERT_TRUE(source.ok());
    BuildOptions options;
    options.output = folder / "scene.fls";
    options.threads = threads;
    ASSERT_TRUE(buildScene(**source, options).ok());
    bytes.push_back(test::slurp(options.output));
  }
  EXPECT_EQ(bytes[0], bytes[1]);
}

TEST_F(Insets, WhatCannotBeMeantIsNamed) {
  const std::string base = file("base.tif", base_field);
  Field away = fine;
  away.west += 100000;
  expectRefused({base}, {.insets = {{file("away.tif", away), 0}}}, {"away.tif", "lies beyond", "base.tif"});
  Field mars = fine;
  mars.crs = "+proj=utm +zone=32 +a=3396190 +b=3376200 +units=m";
  expectRefused({base}, {.insets = {{file("mars.tif", mars), 0}}}, {"mars.tif", "base.tif", "transformation"});
  Field needle = fine;
  needle.step = 0.0001;
  expectRefused({base}, {.insets = {{file("needle.tif", needle), 0}}},
                {"needle.tif", "base.tif", "2^20 a side", "--residual"});
  Field other_zero = fine;
  other_zero.height = [](double x, double y) { return hills(x, y) + 110; };
  EXPECT_TRUE(says(ground({base}, {.insets = {{file("zero.tif", other_zero), 0}}}).warnings, "another vertical datum"));
}

TEST_F(Insets, OfABillionByABillionAreNamed) {
  const std::string vast = (folder / "vast.vrt").string();
  const std::string xml =
      "<VRTDataset rasterXSize=\"1000000000\" rasterYSize=\"1000000000\"><SRS>EPSG:32632</SRS>"
      "<GeoTransform>500000,0.001,0,5150000,0,-0.001</GeoTransform>"
      "<VRTRasterBand dataType=\"Float32\" band=\"1\"/></VRTDataset>";
  test::spit(vast, {xml.begin(), xml.end()});
  expectRefused({file("base.tif", base_field)}, {.insets = {{vast, 0}}}, {"vast.vrt", "2^24", "gdal_translate"});
}

}  // namespace
}  // namespace foreland::terrain
