// A block that is called hidden cannot be seen: neither its true surface nor anything that may be drawn of it, from any
// eye of the ball, by marching along lines of sight.
#include "server/occlusion/block_test.h"

#include <gtest/gtest.h>

#include "tests/server/occlusion/height_field.h"
#include "tests/support/scene.h"
#include "tests/support/wanderer.h"

namespace foreland::server {
namespace {

using proto::BlockId;

glm::dvec3 inBall(Rng& rng) {
  for (;;) {
    const glm::dvec3 p(rng.uniform(-1, 1), rng.uniform(-1, 1), rng.uniform(-1, 1));
    if (glm::length(p) <= 1) return p;
  }
}

class Hidden : public testing::TestWithParam<proto::FrameKind> {};

TEST_P(Hidden, BlocksCannotBeSeenFromAnywhereInTheBall) {
  const uint64_t seed = 23;
  SCOPED_TRACE(testing::Message() << "seed " << seed);
  Rng rng(seed);
  const auto scene = test::makeScene(257, 257, 7, GetParam());
  const Hierarchy hierarchy(scene);
  const auto occluder = Occluder::create(hierarchy).value();
  const BlockTops tops(hierarchy);
  BlockTest test(hierarchy, *occluder, tops);
  const test::HeightField field(hierarchy);
  int hidden = 0, tried = 0;
  for (int view_count = 0; view_count < 40; ++view_count) {
    const double x = rng.uniform(20, 236), y = rng.uniform(20, 236);
    proto::View view = test::viewAt(hierarchy, x, y, field.at(x, y) + rng.uniform(5, 120), rng.uniform(0, 6.28), 0);
    view.tau_px = 1;
    const double radius = rng.uniform(0, 30);
    for (int i = 0; i < 60; ++i) {
      const auto scale = static_cast<uint8_t>(rng.below(4));
      const uint32_t side = BlockId::kSide << scale;
      const BlockId block{scale, static_cast<uint32_t>(rng.below(256 / side)),
                          static_cast<uint32_t>(rng.below(256 / side))};
      ++tried;
      if (!test.isHidden(block, view, radius, 1000)) continue;
      ++hidden;
      for (int sample = 0; sample < 20; ++sample) {
        const double sx = block.x * side + rng.uniform(0, side), sy = block.y * side + rng.uniform(0, side);
        const double top = field.at(std::min(sx, 256.0), std::min(sy, 256.0));
        const glm::dvec3 point = hierarchy.frame().transform().toScene(proto::LatticePosition{sx, sy, top}),
                         eye = view.pose.eye + radius * inBall(rng);
        EXPECT_FALSE(field.isClear(eye, point, 0.5))
            << "block " << int(scale) << " " << block.x << " " << block.y << " at " << sx << " " << sy;
      }
    }
  }
  EXPECT_GT(hidden, tried / 10);
}

INSTANTIATE_TEST_SUITE_P(Frames, Hidden, testing::Values(proto::FrameKind::kPlanar, proto::FrameKind::kGeographic));

// A ridge between two plains: what lies behind it is hidden as far as geometry says.
TEST(Hidden, BehindARidgeAndNotBeforeIt) {
  const auto scene = test::makeScene(
      257, 257, [](uint32_t x, uint32_t) { return std::max(0.0, 100 - 5 * std::abs(static_cast<double>(x) - 131)); });
  const Hierarchy hierarchy(scene);
  const auto occluder = Occluder::create(hierarchy).value();
  const BlockTops tops(hierarchy);
  BlockTest test(hierarchy, *occluder, tops);
  const proto::View view = test::viewAt(hierarchy, 64, 128, 50, 0, 0);
  EXPECT_TRUE(test.isHidden({0, 20, 16}, view, 0, 1000));
  EXPECT_TRUE(test.isHidden({1, 12, 8}, view, 10, 1000));
  EXPECT_FALSE(test.isHidden({0, 12, 16}, view, 0, 1000));
  EXPECT_FALSE(test.isHidden({0, 16, 16}, view, 0, 1000)) << "the ridge itself";
  const proto::View above = test::viewAt(hierarchy, 64, 128, 500, 0, 0);
  EXPECT_FALSE(test.isHidden({0, 20, 16}, above, 0, 1000));
  EXPECT_FALSE(test.isHidden({0, 20, 16}, view, 0, 0)) << "without rays nothing is known";
}

TEST(Tops, AreTheLargestHeightsOfTheirSquares) {
  const auto scene = test::makeScene(65, 49, 3);
  const Hierarchy hierarchy(scene);
  const BlockTops tops(hierarchy);
  for (uint32_t scale = 0; scale < hierarchy.grid().shape().root_log2; ++scale) {
    const uint32_t side = 2u << scale;
    for (uint32_t j = 0; j < tops.rows(scale); ++j)
      for (uint32_t i = 0; i < tops.columns(scale); ++i) {
        int32_t highest = scene->height(proto::NodeId::at(i * side, j * side));
        for (uint32_t y = j * side; y <= (j + 1) * side; ++y)
          for (uint32_t x = i * side; x <= (i + 1) * side; ++x)
            highest = std::max(highest, scene->height(proto::NodeId::at(x, y)));
        ASSERT_EQ(tops.top(scale, i, j), highest) << scale << " " << i << " " << j;
      }
  }
}

}  // namespace
}  // namespace foreland::server
