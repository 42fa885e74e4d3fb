// What is derived of ground that is fine in places only holds against every position of its lattice: squares that are
// flat, tops of blocks, horizons, and what bounds tiles. What is called hidden cannot be seen.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "server/imagery/ground_squares.h"
#include "server/occlusion/block_test.h"
#include "terrain/store/flat_squares.h"
#include "tests/support/height_field.h"
#include "tests/support/seed.h"
#include "tests/support/sparse_scene.h"
#include "tests/support/wanderer.h"

namespace foreland::server {
namespace {

using proto::BlockId;
using proto::NodeId;

constexpr uint32_t kWidth = 257, kHeight = 193;

double ridges(uint32_t x, uint32_t y) {
  return 300 + 110 * std::sin(x / 19.0) * std::cos(y / 23.0) + 6 * std::sin(x / 2.1 + y / 1.7);
}

class SparseGround : public testing::TestWithParam<proto::FrameKind> {
 protected:
  const Hierarchy hierarchy{
      test::makeSparseScene(kWidth, kHeight, ridges, GetParam(), 3, {{90, 80, 40}, {200, 150, 20}})};
  const terrain::Scene& scene = hierarchy.scene();
  const double quantum_m = scene.frame().height_quantum_m;
};

TEST_P(SparseGround, FlatSquaresTileTheDataAndAreFlat) {
  std::map<uint32_t, uint64_t> sides;
  uint64_t area = 0;
  terrain::FlatSquares(scene.grid(), scene.pages()).forEach([&](uint32_t x, uint32_t y, uint32_t side) {
    ++sides[side], area += uint64_t{side} * side;
    ASSERT_TRUE(x + side < kWidth && y + side < kHeight && x % side == 0 && y % side == 0);
    const auto at = [&](uint32_t dx, uint32_t dy) { return double(scene.height(NodeId::at(x + dx, y + dy))); };
    const double a = at(0, 0), b = at(side, 0), c = at(0, side), d = at(side, side);
    for (uint32_t j = 0; j <= side; ++j)
      for (uint32_t i = 0; i <= side; ++i) {
        const double u = double(i) / side, v = double(j) / side;
        const double rising = u > v ? a + u * (b - a) + v * (d - b) : a + v * (c - a) + u * (d - c),
                     falling = u + v < 1 ? a + u * (b - a) + v * (c - a) : d + (1 - u) * (c - d) + (1 - v) * (b - d);
        ASSERT_LE(std::fabs(at(i, j) - ((x / side + y / side) % 2 == 0 ? rising : falling)), 1.01)
            << x + i << ' ' << y + j << " of " << side;
      }
  });
  EXPECT_EQ(area, uint64_t{kWidth - 1} * (kHeight - 1));
  EXPECT_GT(sides[1], 1000u);
  EXPECT_GT(sides[4], 100u);
}

TEST_P(SparseGround, TopsAreAboveAllOfIt) {
  const BlockTops tops(hierarchy);
  double slack = 0;
  for (uint32_t scale = tops.finestScale(); tops.has(scale, 0, 0); ++scale)
    for (uint32_t j = 0; j < tops.rows(scale); ++j)
      for (uint32_t i = 0; i < tops.columns(scale); ++i) {
        const BlockTops::Square& s = tops.square(scale, i, j);
        const uint32_t side = 2u << scale;
        int32_t highest = -proto::kMaxHeight;
        for (uint32_t y = j * side; y <= std::min((j + 1) * side, kHeight - 1); ++y)
          for (uint32_t x = i * side; x <= std::min((i + 1) * side, kWidth - 1); ++x) {
            const int32_t h = scene.height(NodeId::at(x, y));
            highest = std::max(highest, h);
            ASSERT_TRUE(h <= s.top && h >= s.bottom) << scale << ": " << x << ' ' << y;
            const float to_x = 2.0f * float(x - i * side) / float(side) - 1,
                        to_y = 2.0f * float(y - j * side) / float(side) - 1;
            ASSERT_LE(float(h), s.height + s.tilt_x * to_x + s.tilt_y * to_y + 0.01f) << scale << ": " << x << ' ' << y;
          }
        if (highest > -proto::kMaxHeight) slack = std::max(slack, double(s.top - highest));
      }
  EXPECT_LE(slack, 1 + 1e-9) << "they are not idle";
}

TEST_P(SparseGround, HorizonsLieBelowIt) {
  const uint64_t seed = test::randomSeed();
  Rng rng(seed);
  const test::HeightField field(hierarchy);
  const proto::FrameTransform& frame = hierarchy.frame().transform();
  for (const size_t most : {HorizonGrid::kMaxVertices, size_t{4000}}) {
    const auto grid = HorizonGrid::of(hierarchy, most);
    ASSERT_NE(grid, nullptr);
    for (size_t l = 0; l < grid->levels().size(); ++l) {
      const HorizonGrid::Level& level = grid->levels()[l];
      for (int i = 0; i < 4000; ++i) {
        const auto axis = static_cast<size_t>(rng.below(2));
        const auto line = static_cast<uint32_t>(rng.below(level.lines[axis]));
        const double at = rng.uniform(0, level.vertices[axis] - 1.001);
        const uint16_t* heights = level.line(axis == 0 ? HorizonGrid::Along::kX : HorizonGrid::Along::kY, line);
        const double z = grid->steps().metres(
            std::lerp(double(heights[size_t(at)]), double(heights[size_t(at) + 1]), at - std::floor(at)));
        const glm::dvec2 steps = double(1u << l) * (axis == 0 ? glm::dvec2(at, line) : glm::dvec2(line, at)),
                         position = grid->toScene(steps - grid->toGrid(glm::dvec2(0)));
        const proto::LatticePosition p = frame.toLattice({position.x, position.y, z});
        const double ground_m = field.at(std::clamp(p.x, 0.0, kWidth - 1.001), std::clamp(p.y, 0.0, kHeight - 1.001));
        ASSERT_GT(ground_m - p.height_m, -1e-3) << "seed " << seed << ", level " << l << " at " << p.x << ", " << p.y;
      }
    }
  }
}

TEST_P(SparseGround, SquaresOfTilesHoldIt) {
  const GroundSquares squares(hierarchy);
  const auto metres = [&](uint32_t x, uint32_t y) { return float(scene.height(NodeId::at(x, y)) * quantum_m); };
  for (uint32_t level = 0; level < squares.levels(); ++level)
    for (uint32_t y = 0; y + 1 < kHeight; ++y)
      for (uint32_t x = 0; x + 1 < kWidth; ++x) {
        const auto& s = squares.square(level, x / squares.side(level), y / squares.side(level));
        const float h = metres(x, y), along_x = metres(x + 1, y) - h, along_y = metres(x, y + 1) - h;
        ASSERT_TRUE(h >= s.lowest_m && h <= s.highest_m) << level << ": " << x << ' ' << y;
        ASSERT_TRUE(along_x >= s.min_rise_m[0] - quantum_m && along_x <= s.largest_rise_m[0] + quantum_m)
            << x << ' ' << y;
        ASSERT_TRUE(along_y >= s.min_rise_m[1] - quantum_m && along_y <= s.largest_rise_m[1] + quantum_m)
            << x << ' ' << y;
      }
}

TEST_P(SparseGround, BlocksThatAreHiddenCannotBeSeen) {
  const uint64_t seed = test::randomSeed();
  Rng rng(seed);
  SceneOcclusion shared{BlockTops(hierarchy), HorizonGrid::of(hierarchy), nullptr};
  BlockTest test{hierarchy, shared};
  const foreland::test::HeightField field(hierarchy);
  int hidden = 0, tried = 0;
  for (int view_count = 0; view_count < 30; ++view_count) {
    const double x = rng.uniform(20, kWidth - 20.0), y = rng.uniform(20, kHeight - 20.0);
    proto::View view =
        foreland::test::viewAt(hierarchy, x, y, field.at(x, y) + rng.uniform(5, 60), rng.uniform(0, 6.28), 0);
    view.tau_px = 1;
    const EyeCapsule eyes{view.pose.eye, glm::dvec3(0), rng.uniform(0, 10)};
    Horizon horizon(*shared.grid);
    horizon.look(eyes, 3 / view.lens.focalPx());
    for (int i = 0; i < 60; ++i) {
      const auto scale = static_cast<uint8_t>(rng.below(4));
      const uint32_t side = BlockId::kSide << scale;
      const BlockId block{scale, static_cast<uint32_t>(rng.below((kWidth - 1) / side)),
                          static_cast<uint32_t>(rng.below((kHeight - 1) / side))};
      ++tried;
      if (!test.isBehind(block, {view.lens, view.tau_px}, horizon)) continue;
      ++hidden;
      for (int sample = 0; sample < 20; ++sample) {
        const double sx = block.x * side + rng.uniform(0, side), sy = block.y * side + rng.uniform(0, side);
        const glm::dvec3 point =
            hierarchy.frame().transform().toScene(proto::LatticePosition{sx, sy, field.at(sx, sy)});
        EXPECT_FALSE(field.isClear(eyes.eye, point, 0.5)) << "seed " << seed << ": " << sx << ' ' << sy;
      }
    }
  }
  EXPECT_GT(hidden, tried / 10);
}

INSTANTIATE_TEST_SUITE_P(Frames, SparseGround,
                         testing::Values(proto::FrameKind::kPlanar, proto::FrameKind::kGeographic),
                         [](const auto& kind) {
                           return kind.param == proto::FrameKind::kPlanar ? "Planar" : "Geographic";
                         });

}  // namespace
}  // namespace foreland::server
