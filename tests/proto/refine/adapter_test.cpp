// The law of adaptation: from any section to any other, it ends where refinement from scratch does, node for node.
#include <gtest/gtest.h>

#include "tests/support/scene.h"
#include "tests/support/wanderer.h"

namespace foreland::proto {
namespace {

using server::Hierarchy;
using test::viewAt;
using test::Wanderer;

constexpr size_t kNoLimit = 1u << 30;

class Adaptation : public testing::TestWithParam<FrameKind> {};

TEST_P(Adaptation, EqualsRefinementFromScratchOnAnyMotion) {
  const uint64_t seed = testing::UnitTest::GetInstance()->random_seed();
  RecordProperty("seed", std::to_string(seed));
  for (auto [w, h] : {std::pair{129u, 129u}, {190u, 75u}}) {
    const Hierarchy hierarchy(test::makeScene(w, h, seed, GetParam()));
    Wanderer wanderer(hierarchy, seed);
    TerrainAdapter adapter(hierarchy.domain());
    InMemoryNodes source = hierarchy.source();
    AdaptScratch adapt_scratch;
    RefineScratch scratch;
    Section expected, held;
    for (int i = 0; i < 600; ++i) {
      const View view = wanderer.next();
      CutDelta delta;
      ASSERT_TRUE(adapter.adapt(view, kNoLimit, source, adapt_scratch, delta));
      adapter.validate();
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
  InMemoryNodes source = hierarchy.source();
  AdaptScratch adapt_scratch;
  CutDelta delta;
  ASSERT_TRUE(adapter.adapt(viewAt(hierarchy, 200, 200, 1500, 0.3, -0.4), kNoLimit, source, adapt_scratch, delta));
  const uint64_t from_scratch = adapter.testCount();
  ASSERT_TRUE(
      adapter.adapt(viewAt(hierarchy, 200.5, 200, 1500, 0.3, -0.4), kNoLimit, source, adapt_scratch, delta));  // 5 m
  EXPECT_LT(adapter.testCount() - from_scratch, from_scratch / 5);
}

// An adapter that is made from a section's nodes alone adapts like any other.
TEST_P(Adaptation, ResumesFromASectionThatItIsGiven) {
  const uint64_t seed = testing::UnitTest::GetInstance()->random_seed();
  const Hierarchy hierarchy(test::makeScene(129u, 100u, seed, GetParam()));
  Wanderer wanderer(hierarchy, seed);
  InMemoryNodes source = hierarchy.source();
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
  InMemoryNodes source = hierarchy.source();
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
