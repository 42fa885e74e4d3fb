// The law of adaptation: from any section to any other, it ends where refinement from scratch does, node for node.
#include <gtest/gtest.h>

#include <cmath>

#include "base/rng.h"
#include "server/section/hierarchy.h"
#include "tests/support/scene.h"

namespace foreland::proto {
namespace {

using server::Hierarchy;

constexpr size_t kNoLimit = 1u << 30;

View viewAt(const Hierarchy& h, double x, double y, double height, double yaw, double pitch) {
  View view;
  view.pose.eye = h.frame().transform().toScene(LatticePlace{x, y, height});
  view.pose.orientation =
      lookAlong({std::cos(yaw) * std::cos(pitch), std::sin(yaw) * std::cos(pitch), std::sin(pitch)}, {0, 0, 1});
  view.lens = {1.0, 640, 360};
  return view;
}

// A wandering camera: mostly small steps, now and then a turn, a jump, another tolerance, ball, sweep or lens.
class Wanderer {
 public:
  Wanderer(const Hierarchy& h, uint64_t seed) : hierarchy_(h), rng_(seed) { jump(); }

  View next() {
    const GridShape& shape = hierarchy_.grid().shape();
    switch (rng_.below(30)) {
      case 0:
        jump();
        break;
      case 1:
        yaw_ += rng_.uniform(-2, 2);
        break;
      case 2:
        tau_ = std::pow(2, rng_.uniform(-3, 3));
        break;
      case 3:
        ball_ = rng_.uniform(0, 60);
        break;
      case 4:
        turn_ = rng_.below(2) ? rng_.uniform(0, 0.5) : 0;
        break;
      case 5:
        fov_ = rng_.uniform(0.4, 1.8);
        break;
      case 6:
        return last_;  // no motion at all
      default:
        x_ += rng_.uniform(-1.5, 1.5);
        y_ += rng_.uniform(-1.5, 1.5);
        height_ += rng_.uniform(-20, 20);
        yaw_ += rng_.uniform(-0.02, 0.02);
        tau_ *= rng_.uniform(0.98, 1.02);
    }
    last_ = viewAt(hierarchy_, std::fmod(x_ + shape.samples_x, shape.samples_x),
                   std::fmod(y_ + shape.samples_y, shape.samples_y), height_, yaw_, pitch_);
    last_.tau_px = tau_;
    last_.ball_m = ball_;
    last_.turn_rad = turn_;
    last_.lens.vertical_fov_rad = fov_;
    return last_;
  }

 private:
  void jump() {
    x_ = rng_.uniform(0, hierarchy_.grid().shape().samples_x);
    y_ = rng_.uniform(0, hierarchy_.grid().shape().samples_y);
    height_ = 500 + std::pow(10, rng_.uniform(1, 4));
    yaw_ = rng_.uniform(0, 6.28);
    pitch_ = rng_.uniform(-1.5, 0.3);
  }

  const Hierarchy& hierarchy_;
  Rng rng_;
  double x_ = 0, y_ = 0, height_ = 0, yaw_ = 0, pitch_ = 0, tau_ = 1, ball_ = 0, turn_ = 0, fov_ = 1;
  View last_;
};

class Adaptation : public testing::TestWithParam<FrameKind> {};

TEST_P(Adaptation, EqualsRefinementFromScratchOnAnyMotion) {
  const uint64_t seed = testing::UnitTest::GetInstance()->random_seed() + 1;
  RecordProperty("seed", std::to_string(seed));
  for (auto [w, h] : {std::pair{129u, 129u}, {190u, 75u}}) {
    const Hierarchy hierarchy(test::makeScene(w, h, seed, GetParam()));
    Wanderer wanderer(hierarchy, seed);
    TerrainAdapter adapter(hierarchy.domain());
    PlainNodes source = hierarchy.source();
    AdaptScratch adapt_scratch;
    RefineScratch scratch;
    Section expected, held;
    for (int i = 0; i < 600; ++i) {
      const View view = wanderer.next();
      CutDelta delta;
      ASSERT_TRUE(adapter.adapt(view, kNoLimit, source, adapt_scratch, delta));
      adapter.validate();
      settle(delta);
      ASSERT_TRUE(refine(hierarchy, view, kNoLimit, scratch, expected));
      ASSERT_EQ(adapter.section(), expected) << "seed " << seed << ", step " << i;
      ASSERT_EQ(apply(held, delta), expected) << "seed " << seed << ", step " << i;
      ASSERT_EQ(adapter.nodeCount(), expected.slots.size());
      held = expected;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Frames, Adaptation, testing::Values(FrameKind::kPlanar, FrameKind::kGeographic));

TEST(Adapter, TestsOnlyAFewNodesOnASmallMotion) {
  const Hierarchy hierarchy(test::makeScene(513, 513, 21));
  TerrainAdapter adapter(hierarchy.domain());
  PlainNodes source = hierarchy.source();
  AdaptScratch adapt_scratch;
  CutDelta delta;
  ASSERT_TRUE(adapter.adapt(viewAt(hierarchy, 200, 200, 1500, 0.3, -0.4), kNoLimit, source, adapt_scratch, delta));
  const uint64_t from_scratch = adapter.testCount();
  ASSERT_TRUE(
      adapter.adapt(viewAt(hierarchy, 200.5, 200, 1500, 0.3, -0.4), kNoLimit, source, adapt_scratch, delta));  // 5 m
  EXPECT_LT(adapter.testCount() - from_scratch, from_scratch / 5);
}

// A section presented by its nodes alone: the same from there on.
TEST_P(Adaptation, GoesOnFromASectionThatItIsGiven) {
  const uint64_t seed = testing::UnitTest::GetInstance()->random_seed() + 1;
  const Hierarchy hierarchy(test::makeScene(129u, 100u, seed, GetParam()));
  Wanderer wanderer(hierarchy, seed);
  PlainNodes source = hierarchy.source();
  AdaptScratch adapt_scratch;
  RefineScratch scratch;
  Section given, expected;
  for (int round = 0; round < 40; ++round) {
    ASSERT_TRUE(refine(hierarchy, wanderer.next(), kNoLimit, scratch, given));
    TerrainAdapter adapter(hierarchy.domain(), given.slots, source);
    for (int i = 0; i < 5; ++i) {
      const View view = wanderer.next();
      CutDelta delta;
      ASSERT_TRUE(adapter.adapt(view, kNoLimit, source, adapt_scratch, delta));
      adapter.validate();
      ASSERT_TRUE(refine(hierarchy, view, kNoLimit, scratch, expected));
      ASSERT_EQ(adapter.section(), expected) << "seed " << seed << ", round " << round;
    }
  }
}

TEST(Adapter, RefusesSectionsBeyondItsLimit) {
  const Hierarchy hierarchy(test::makeScene(257, 257, 22));
  PlainNodes source = hierarchy.source();
  AdaptScratch adapt_scratch;
  CutDelta delta;
  const View view = viewAt(hierarchy, 100, 100, 1500, 0.3, -0.8);
  TerrainAdapter free(hierarchy.domain()), limited(hierarchy.domain()), enough(hierarchy.domain());
  ASSERT_TRUE(free.adapt(view, kNoLimit, source, adapt_scratch, delta));
  EXPECT_FALSE(limited.adapt(view, free.nodeCount() - 1, source, adapt_scratch, delta));
  EXPECT_TRUE(enough.adapt(view, free.nodeCount(), source, adapt_scratch, delta));
}

}  // namespace
}  // namespace foreland::proto
