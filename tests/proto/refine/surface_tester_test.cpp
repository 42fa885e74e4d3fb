// The law of adaptation, on surfaces: from any section to any other, it ends with exactly the nodes that pass the test.
#include <gtest/gtest.h>

#include "proto/refine/adapter.h"
#include "terrain/surface/bounds.h"
#include "tests/support/surface_wanderer.h"
#include "tests/support/surfaces.h"

namespace foreland::proto {
namespace {

using test::SurfaceWanderer;

constexpr size_t kAnyNumber = 1u << 30;

// What passes is closed, so a look at every node gives the section.
Section everyNodeThatPasses(const SurfaceDomain& domain, const std::vector<SurfaceRecord>& records, const View& view) {
  const SurfaceMetric metric = domain.metric(view);
  Section section;
  terrain::forEachNode(domain.topology(), [&](NodeId, Slot slot) {
    if (metric.passes(SurfaceBounds::of(records[slot], domain.quantum_m))) section.slots.push_back(slot);
  });
  return section;
}

class SurfaceAdaptation : public testing::TestWithParam<MeshRule> {};

TEST_P(SurfaceAdaptation, EqualsTheNodesThatPassOnAnyMotion) {
  const uint64_t seed = testing::UnitTest::GetInstance()->random_seed();
  RecordProperty("seed", std::to_string(seed));
  for (const test::NamedSurface& named : test::surfaces(GetParam(), GetParam() == MeshRule::kBisection ? 2 : 3)) {
    const auto records = terrain::computeBounds(named.surface, {.threads = 1});
    const SurfaceDomain domain{
        .mesh = &named.surface.topology, .quantum_m = named.surface.quantum_m, .is_closed = named.is_closed};
    SurfaceWanderer wanderer(seed);
    SurfaceAdapter adapter(domain);
    AdaptScratch scratch;
    Section held;
    size_t most = 0;
    for (int i = 0; i < 300; ++i) {
      const View view = wanderer.next();
      CutDelta delta;
      ASSERT_TRUE(adapter.adapt(view, kAnyNumber, records, scratch, delta));
      adapter.validate();
      const Section expected = everyNodeThatPasses(domain, records, view);
      ASSERT_EQ(adapter.section(), expected) << named.name << ", seed " << seed << ", step " << i;
      ASSERT_EQ(apply(held, delta), expected) << named.name << ", seed " << seed << ", step " << i;
      held = expected;
      most = std::max(most, held.slots.size());
    }
    EXPECT_TRUE(most > 0 || named.name == "Flat") << named.name;
  }
}

INSTANTIATE_TEST_SUITE_P(Rules, SurfaceAdaptation, testing::Values(MeshRule::kQuadrisection, MeshRule::kBisection));

TEST(SurfaceAdapter, TestsOnlyAFewNodesOnASmallMotion) {
  const terrain::TrueSurface sphere = *terrain::makeSphere(1, {MeshRule::kQuadrisection, 5, 1e-6});
  const auto records = terrain::computeBounds(sphere, {.threads = 1});
  const SurfaceDomain domain{.mesh = &sphere.topology, .quantum_m = sphere.quantum_m};
  SurfaceAdapter adapter(domain);
  AdaptScratch scratch;
  CutDelta delta;
  View view;
  view.pose = {{0, -3, 0}, lookAlong({0, 1, 0}, {0, 0, 1})};
  ASSERT_TRUE(adapter.adapt(view, kAnyNumber, records, scratch, delta));
  const uint64_t from_scratch = adapter.testCount();
  view.pose.eye.x += 0.001;
  ASSERT_TRUE(adapter.adapt(view, kAnyNumber, records, scratch, delta));
  EXPECT_LT(adapter.testCount() - from_scratch, from_scratch / 5);
  EXPECT_GT(adapter.nodeCount(), 100u);
}

}  // namespace
}  // namespace foreland::proto
