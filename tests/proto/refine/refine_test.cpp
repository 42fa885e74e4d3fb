// Laws of refinement: what passes is closed, the walk finds all of it and nothing else, and the bound holds.
#include <gtest/gtest.h>

#include <cmath>

#include "base/rng.h"
#include "server/section/hierarchy.h"
#include "tests/support/scene.h"

namespace foreland::proto {
namespace {

using server::Hierarchy;

constexpr size_t kNoLimit = 1u << 30;

View randomView(const Hierarchy& h, Rng& rng) {
  const GridShape& shape = h.grid().shape();
  const LatticePosition place{rng.uniform(-50, shape.samples_x + 50), rng.uniform(-50, shape.samples_y + 50),
                              600 + std::pow(10, rng.uniform(0, 4))};
  View view;
  view.pose.eye = h.frame().transform().toScene(place);
  const double yaw = rng.uniform(0, 6.28), pitch = rng.uniform(-1.5, 0.5);
  view.pose.orientation =
      lookAlong({std::cos(yaw) * std::cos(pitch), std::sin(yaw) * std::cos(pitch), std::sin(pitch)}, {0, 0, 1});
  view.lens = {rng.uniform(0.3, 2.0), 640, 360};
  view.tau_px = std::pow(2, rng.uniform(-2, 4));
  return view;
}

// The definition, node by node: its sphere meets the view and its error would be seen. Positions come from the frame.
std::vector<Slot> everyNodeThatPasses(const Hierarchy& h, const View& view) {
  const Metric metric = h.domain().metric(view);
  std::vector<Slot> slots;
  for (Slot slot = 0; slot < h.grid().slotCount(); ++slot) {
    const NodeId n = h.grid().node(slot);
    if (h.grid().isBase(n)) continue;
    const NodeRecord& r = h.nodes()[slot];
    const glm::dvec3 p = h.frame().position(n, r.middle()) - view.pose.eye;
    const NodePosition position{metric.frustum().toView(p.x, p.y, p.z), std::hypot(p.x, p.y)};
    if (metric.passes(position, h.domain().radius(h.grid().level(n), r.radius()), r.error().metres()))
      slots.push_back(slot);
  }
  return slots;
}

class Refinement : public testing::TestWithParam<FrameKind> {};

TEST_P(Refinement, IsClosedAndIsEveryNodeThatPasses) {
  const uint64_t seed = testing::UnitTest::GetInstance()->random_seed();
  RecordProperty("seed", std::to_string(seed));
  Rng rng(seed);
  for (auto [w, h] : {std::pair{65u, 65u}, {90u, 47u}, {33u, 130u}}) {
    const Hierarchy hierarchy(test::makeScene(w, h, rng.next(), GetParam()));
    RefineScratch scratch;
    Section section;
    for (int i = 0; i < 25; ++i) {
      const View view = randomView(hierarchy, rng);
      ASSERT_TRUE(refine(hierarchy, view, kNoLimit, scratch, section));
      const Status closed = validate(hierarchy.grid(), section);
      EXPECT_TRUE(closed.ok()) << "seed " << seed << ": " << closed.error().message;
      const std::vector<Slot> expected = everyNodeThatPasses(hierarchy, view);
      // The walk computes positions in another order of operations; nodes within rounding of the threshold may differ.
      std::vector<Slot> differing;
      std::set_symmetric_difference(expected.begin(), expected.end(), section.slots.begin(), section.slots.end(),
                                    std::back_inserter(differing));
      EXPECT_LE(differing.size(), 1u) << "seed " << seed;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Frames, Refinement, testing::Values(FrameKind::kPlanar, FrameKind::kGeographic));

TEST(RefineLimits, StopsAtTheStatedNumberOfNodes) {
  const Hierarchy hierarchy(test::makeScene(129, 129, 3));
  View view{{hierarchy.frame().transform().toScene(LatticePosition{64, 64, 3000}), lookAlong({0, 0, -1}, {0, 0, 1})},
            {},
            0.01};
  RefineScratch scratch;
  Section section;
  EXPECT_TRUE(refine(hierarchy, view, kNoLimit, scratch, section));
  const size_t all = section.slots.size();
  EXPECT_GT(all, 1000u);
  EXPECT_FALSE(refine(hierarchy, view, all - 1, scratch, section));
  EXPECT_TRUE(refine(hierarchy, view, all, scratch, section));
}

TEST(RefineLimits, AbsurdPosesGiveAValidSection) {
  const Hierarchy hierarchy(test::makeScene(65, 65, 4));
  RefineScratch scratch;
  Section section;
  const Pose poses[] = {{{0, 0, -5000}, lookAlong({0, 0, 1}, {0, 0, 1})},  // inside the ground, looking up
                        {{1e8, 1e8, 1e8}, lookAlong({-1, -1, -1}, {0, 0, 1})},
                        {{0, 0, 1e8}, lookAlong({0, 0, -1}, {0, 0, 1})}};
  for (const Pose& pose : poses)
    for (double tau : {1e-6, 1.0, 1e9}) {
      EXPECT_TRUE(refine(hierarchy, View{pose, {}, tau}, kNoLimit, scratch, section));
      EXPECT_TRUE(validate(hierarchy.grid(), section).ok());
    }
}

// The region is wider for `wide` than for its pose alone.
struct Views {
  View wide, alone;
};
Views randomViews(const Hierarchy& h, Rng& rng) {
  View view = randomView(h, rng);
  const View alone = view;
  view.region_radius_m = rng.uniform(0, 50);
  view.region_angle_rad = rng.uniform(0, 0.4);
  return {view, alone};
}

TEST(EstimatedSize, IsTheSizeOfSmallSections) {
  const uint64_t seed = testing::UnitTest::GetInstance()->random_seed();
  RecordProperty("seed", std::to_string(seed));
  Rng rng(seed);
  const Hierarchy hierarchy(test::makeScene(65, 65, rng.next()));  // no level has many nodes
  RefineScratch scratch;
  Section wide, alone;
  for (int i = 0; i < 50; ++i) {
    const Views views = randomViews(hierarchy, rng);
    ASSERT_TRUE(refine(hierarchy, views.wide, kNoLimit, scratch, wide));
    ASSERT_TRUE(refine(hierarchy, views.alone, kNoLimit, scratch, alone));
    const SampledSize size = estimateSize(hierarchy, views.wide, views.alone, scratch);
    EXPECT_EQ(size.nodes, static_cast<double>(wide.slots.size())) << "seed " << seed;
    EXPECT_EQ(size.within, static_cast<double>(alone.slots.size())) << "seed " << seed;
    EXPECT_EQ(size.sample, wide.slots.size()) << "seed " << seed;
  }
}

TEST(EstimatedSize, IsWithinATenthOfThatOfLargeSections) {
  const Hierarchy hierarchy(test::makeScene(513, 513, 6));
  RefineScratch scratch;
  Section section;
  Rng rng(7);
  for (int i = 0; i < 10; ++i) {
    Views views{randomView(hierarchy, rng), {}};
    views.wide.tau_px = 0.01;
    views.wide.pose.orientation = lookAlong({std::cos(0.6 * i), std::sin(0.6 * i), -1}, {0, 0, 1});
    views.alone = views.wide;
    views.wide.region_angle_rad = 0.1;
    const SampledSize size = estimateSize(hierarchy, views.wide, views.alone, scratch);
    ASSERT_TRUE(refine(hierarchy, views.wide, kNoLimit, scratch, section));
    const auto nodes = static_cast<double>(section.slots.size());
    EXPECT_NEAR(size.nodes, nodes, 0.1 * nodes + 1) << i;
    ASSERT_TRUE(refine(hierarchy, views.alone, kNoLimit, scratch, section));
    const auto alone = static_cast<double>(section.slots.size());
    EXPECT_NEAR(size.within, alone, 0.1 * alone + 1) << i;
    EXPECT_LT(static_cast<double>(size.sample), std::max(0.6 * nodes, 50'000.0)) << i;
  }
}

TEST(CountNeeded, CountsTheNodesOfASmallerSection) {
  const uint64_t seed = testing::UnitTest::GetInstance()->random_seed();
  RecordProperty("seed", std::to_string(seed));
  Rng rng(seed);
  const Hierarchy hierarchy(test::makeScene(129, 90, rng.next()));
  RefineScratch scratch;
  Section wide, alone;
  for (int i = 0; i < 30; ++i) {
    const Views views = randomViews(hierarchy, rng);
    ASSERT_TRUE(refine(hierarchy, views.wide, kNoLimit, scratch, wide));
    ASSERT_TRUE(refine(hierarchy, views.alone, kNoLimit, scratch, alone));
    EXPECT_EQ(countNeeded(hierarchy.domain(), hierarchy.nodes(), views.alone, wide.slots), alone.slots.size())
        << "seed " << seed;
  }
}

}  // namespace
}  // namespace foreland::proto
