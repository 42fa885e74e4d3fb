#include "lab/occlusion/possible.h"

#include <gtest/gtest.h>

#include "lab/tests/occlusion/ridge.h"
#include "oracle/scene_truth.h"

namespace foreland::lab {
namespace {

class Possible : public testing::Test {
 protected:
  server::Hierarchy hierarchy_{test::ridgeScene()};
  oracle::LineOfSight terrain_{
      oracle::truthOf(std::shared_ptr<const terrain::Scene>(&hierarchy_.scene(), [](const auto*) {}))};
  proto::Path path_ = test::ridgeFlight(hierarchy_, 4);
  proto::Lens lens_ = test::ridgeOptions(4).lens;
};

TEST_F(Possible, NeedsMoreNodesTheMoreItAllowsFor) {
  proto::View view{path_.at(Time::seconds(2)), lens_, 0.5};
  proto::RefineScratch scratch;
  proto::Section section;
  ASSERT_TRUE(server::refine(hierarchy_, view, 1u << 24, scratch, section));
  const PossibleNodes nodes =
      PossibleJudge(hierarchy_, terrain_)
          .count(section.slots, {view.pose, path_.at(Time::seconds(1.8)), path_.at(Time::seconds(2.2))}, lens_, 0.5);
  EXPECT_GT(nodes.visible, 100);
  EXPECT_LT(nodes.visible, nodes.vertices);
  EXPECT_LT(nodes.vertices, nodes.raised);
  EXPECT_LT(nodes.raised, nodes.supports);
  EXPECT_LT(nodes.supports, nodes.blocks);
  EXPECT_LE(nodes.blocks, nodes.region);
  EXPECT_LT(nodes.region, nodes.all);
}

TEST_F(Possible, CountsVisibleSamplesInRectangles) {
  const proto::Pose pose = path_.at(Time{});
  VisibleSamples samples(terrain_);
  samples.see(pose, lens_, 0);
  samples.sum();
  const auto isVisible = [&](uint32_t x, uint32_t y) { return samples.any(x, y, x, y); };
  Rng rng(3);
  for (int i = 0; i < 300; ++i) {
    const auto x = static_cast<uint32_t>(rng.below(250)), y = static_cast<uint32_t>(rng.below(250)),
               width = static_cast<uint32_t>(rng.below(7)), height = static_cast<uint32_t>(rng.below(7));
    bool expected = false;
    for (uint32_t j = y; j <= y + height; ++j)
      for (uint32_t k = x; k <= x + width; ++k) expected |= isVisible(k, j);
    EXPECT_EQ(samples.any(x, y, x + width, y + height), expected);
  }
  // Ahead of the eye, on the ridge's near side, and behind the ridge.
  EXPECT_TRUE(samples.any(90, 120, 99, 136));
  EXPECT_FALSE(samples.any(110, 100, 400, 156));
  EXPECT_FALSE(samples.any(-20, -20, -1, -1));
}

}  // namespace
}  // namespace foreland::lab
