// A block that is called hidden cannot be seen: neither its true surface nor anything that may be drawn of it, from any
// eye of the sweep, by marching along lines of sight.
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

// A scene, and all that a test of its blocks needs.
struct Ground {
  explicit Ground(std::shared_ptr<const terrain::Scene> scene) : hierarchy(std::move(scene)) {}

  const Hierarchy hierarchy;
  const std::shared_ptr<const Occluder> occluder = Occluder::create(hierarchy).value();
  const BlockTops tops{hierarchy};
  BlockTest test{hierarchy, *occluder, tops};
  const foreland::test::HeightField field{hierarchy};
};

class Hidden : public testing::TestWithParam<proto::FrameKind> {};

TEST_P(Hidden, BlocksCannotBeSeenFromAnywhereInTheSweep) {
  const uint64_t seed = 23;
  SCOPED_TRACE(testing::Message() << "seed " << seed);
  Rng rng(seed);
  const auto scene = test::makeScene(257, 257, 7, GetParam());
  Ground ground(scene);
  int hidden = 0, tried = 0;
  for (int view_count = 0; view_count < 40; ++view_count) {
    const double x = rng.uniform(20, 236), y = rng.uniform(20, 236);
    proto::View view =
        test::viewAt(ground.hierarchy, x, y, ground.field.at(x, y) + rng.uniform(5, 120), rng.uniform(0, 6.28), 0);
    view.tau_px = 1;
    const EyeSweep eyes{view.pose.eye, rng.below(4) == 0 ? glm::dvec3(0) : rng.uniform(0, 60) * inBall(rng),
                        rng.uniform(0, 30)};
    for (int i = 0; i < 60; ++i) {
      const auto scale = static_cast<uint8_t>(rng.below(4));
      const uint32_t side = BlockId::kSide << scale;
      const BlockId block{scale, static_cast<uint32_t>(rng.below(256 / side)),
                          static_cast<uint32_t>(rng.below(256 / side))};
      ++tried;
      if (!ground.test.isHidden(block, view, eyes, 1000)) continue;
      ++hidden;
      for (int sample = 0; sample < 20; ++sample) {
        const double sx = block.x * side + rng.uniform(0, side), sy = block.y * side + rng.uniform(0, side);
        const double top = ground.field.at(std::min(sx, 256.0), std::min(sy, 256.0));
        const glm::dvec3 point = ground.hierarchy.frame().transform().toScene(proto::LatticePosition{sx, sy, top}),
                         eye = eyes.eye + rng.uniform() * eyes.way + eyes.radius_m * inBall(rng);
        EXPECT_FALSE(ground.field.isClear(eye, point, 0.5))
            << "block " << int(scale) << " " << block.x << " " << block.y << " at " << sx << " " << sy;
      }
    }
  }
  EXPECT_GT(hidden, tried / 10);
}

// At the height where a block is only just hidden, eyes at the ends of the sweep and on top of its ball do not see it.
TEST_P(Hidden, BlocksCannotBeSeenFromTheMostTellingEyes) {
  const auto seed = static_cast<uint64_t>(testing::UnitTest::GetInstance()->random_seed());
  SCOPED_TRACE(testing::Message() << "seed " << seed);
  Rng rng(seed);
  const auto scene = test::makeScene(
      257, 257,
      [](uint32_t x, uint32_t y) { return std::max(0.0, 90 - 4 * std::abs(x - 131.0) + 12 * std::sin(0.21 * y)); },
      GetParam());
  Ground ground(scene);
  int critical = 0, nearly_seen = 0;
  for (int round = 0; round < 60; ++round) {
    const double x = rng.uniform(20, 70), y = rng.uniform(60, 196);
    const auto scale = static_cast<uint8_t>(rng.below(3));
    const uint32_t side = BlockId::kSide << scale;
    const BlockId block{scale, static_cast<uint32_t>((160 + rng.below(60)) / side),
                        static_cast<uint32_t>((y + rng.uniform(-50, 50)) / side)};
    proto::View view = test::viewAt(ground.hierarchy, x, y, 0, 0, 0);
    EyeSweep eyes{view.pose.eye, rng.uniform(0, 400) * inBall(rng), rng.below(2) * rng.uniform(0, 30)};
    const glm::dvec3 level = eyes.eye;
    const auto isHiddenAt = [&](double height) {
      eyes.eye = level + glm::dvec3(0, 0, height);
      return ground.test.isHidden(block, view, eyes, 1000);
    };
    double low = -1000, high = 3000;
    if (!isHiddenAt(low) || isHiddenAt(high)) continue;
    while (high - low > 0.1) (isHiddenAt(0.5 * (low + high)) ? low : high) = 0.5 * (low + high);
    ++critical;
    isHiddenAt(low);
    bool seen_from_above = false;
    for (int sample = 0; sample < 40; ++sample) {
      const double sx = side * (block.x + rng.uniform()), sy = side * (block.y + rng.uniform());
      const glm::dvec3 point =
          ground.hierarchy.frame().transform().toScene(proto::LatticePosition{sx, sy, ground.field.at(sx, sy)});
      const glm::dvec3 out = rng.below(2) ? glm::dvec3(0, 0, 1) : glm::normalize(inBall(rng));
      const glm::dvec3 eye = eyes.eye + static_cast<double>(rng.below(2)) * eyes.way + eyes.radius_m * out;
      EXPECT_FALSE(ground.field.isClear(eye, point, 0.3)) << int(scale) << " " << block.x << " " << block.y;
      seen_from_above |= ground.field.isClear(
          eye + glm::dvec3(0, 0, 40 + 2 * eyes.radius_m + 1.5 * glm::length(eyes.way)), point, 0.3);
    }
    nearly_seen += seen_from_above ? 1 : 0;
  }
  EXPECT_GT(critical, 25);
  EXPECT_GT(nearly_seen, critical / 2);
}

// A ridge between two plains: what lies behind it is hidden as far as geometry says.
TEST(Hidden, BehindARidgeAndNotBeforeIt) {
  const auto scene = test::makeScene(
      257, 257, [](uint32_t x, uint32_t) { return std::max(0.0, 100 - 5 * std::abs(static_cast<double>(x) - 131)); });
  Ground ground(scene);
  const proto::View view = test::viewAt(ground.hierarchy, 64, 128, 50, 0, 0);
  EXPECT_TRUE(ground.test.isHidden({0, 40, 32}, view, EyeSweep{view.pose.eye}, 1000));
  EXPECT_TRUE(ground.test.isHidden({1, 24, 16}, view, EyeSweep{view.pose.eye, {}, 10}, 1000));
  EXPECT_FALSE(ground.test.isHidden({0, 24, 32}, view, EyeSweep{view.pose.eye}, 1000));
  EXPECT_FALSE(ground.test.isHidden({0, 32, 32}, view, EyeSweep{view.pose.eye}, 1000)) << "the ridge itself";
  const proto::View above = test::viewAt(ground.hierarchy, 64, 128, 500, 0, 0);
  EXPECT_FALSE(ground.test.isHidden({0, 40, 32}, above, EyeSweep{above.pose.eye}, 1000));
  EXPECT_FALSE(ground.test.isHidden({0, 40, 32}, view, EyeSweep{view.pose.eye}, 0)) << "without rays nothing is known";
}

INSTANTIATE_TEST_SUITE_P(Frames, Hidden, testing::Values(proto::FrameKind::kPlanar, proto::FrameKind::kGeographic));

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
