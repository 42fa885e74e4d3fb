// The laws of sections on a globe: over edges, corners and poles what passes is closed, adaptation ends where
// refinement from scratch does, and nothing that can be seen is left out as below the horizon.
#include <gtest/gtest.h>

#include <algorithm>
#include <glm/geometric.hpp>

#include "base/rng.h"
#include "proto/refine/adapter.h"
#include "server/section/hierarchy.h"
#include "tests/support/globe_scene.h"
#include "tests/support/seed.h"
#include "tests/support/wanderer.h"

namespace foreland::proto {
namespace {

using server::Hierarchy;
using test::viewAt;
using test::Wanderer;

constexpr size_t kNoLimit = 1u << 30;

// The definition, node by node.
std::vector<Slot> everyNodeThatPasses(const Hierarchy& h, const View& view) {
  const Metric metric = h.domain().metric(view);
  std::vector<Slot> slots;
  for (Slot slot = 0; slot < h.grid().slotCount(); ++slot) {
    const NodeId n = h.grid().node(slot);
    if (h.grid().isBase(n) || !h.nodes().hasPage(slot)) continue;
    const NodeRecord& r = h.nodes()[slot];
    const glm::dvec3 p = h.frame().position(n, r.middle()) - view.pose.eye;
    const NodePosition position{metric.frustum().toView(p.x, p.y, p.z), std::hypot(p.x, p.y)};
    const float radius = h.domain().radius(h.grid().level(n), r.radius());
    if (metric.passes(position, radius, r.error().metres()) && !metric.horizon().hides(position, radius))
      slots.push_back(slot);
  }
  return slots;
}

// Around everything that is special: the eye at a pole, over an edge or a corner, or anywhere.
View specialView(const Hierarchy& h, Rng& rng) {
  const double side = h.grid().rootSize();
  const auto face = static_cast<double>(rng.below(6));
  double x = rng.uniform(0, side), y = rng.uniform(0, side);
  if (rng.below(3) == 0) x = rng.below(2) == 0 ? 0.01 : side - 0.01;
  if (rng.below(3) == 0) y = rng.below(2) == 0 ? 0.01 : side - 0.01;
  if (rng.below(6) == 0) x = y = side / 2;  // the poles are the middles of faces 2 and 5
  View view =
      viewAt(h, face * side + x, y, 500 + std::exp(rng.uniform(3, 11)), rng.uniform(0, 6.28), rng.uniform(-1.57, 0.2));
  view.tau_px = std::exp2(rng.uniform(-1, 4));
  if (rng.below(2) == 0) view.region_radius_m = rng.uniform(0, 0.2) * glm::length(view.pose.eye) - 2000;
  view.region_radius_m = std::max(0.0, view.region_radius_m);
  return view;
}

class GlobeSections : public testing::TestWithParam<uint32_t> {
 protected:
  const uint64_t seed = test::randomSeed();
  Rng rng{seed};
  const Hierarchy hierarchy{test::makeGlobeScene(GetParam() > 0 ? 7 : 6, seed, GetParam())};
};

TEST_P(GlobeSections, AreClosedAndEveryNodeThatPasses) {
  RefineScratch scratch;
  Section section;
  size_t nodes = 0;
  for (int i = 0; i < 60; ++i) {
    const View view = specialView(hierarchy, rng);
    ASSERT_TRUE(refine(hierarchy, view, kNoLimit, scratch, section));
    const Status closed = validate(hierarchy.grid(), section);
    ASSERT_TRUE(closed.ok()) << closed.error().message;
    const std::vector<Slot> expected = everyNodeThatPasses(hierarchy, view);
    ASSERT_EQ(section.slots, expected);
    nodes += expected.size();
  }
  EXPECT_GT(nodes, 10'000u);
}

TEST_P(GlobeSections, AdaptationEqualsRefinementFromScratch) {
  TerrainAdapter adapter(hierarchy.domain());
  InMemoryNodes source = hierarchy.source();
  AdaptScratch adapt_scratch;
  RefineScratch scratch;
  Section expected, held;
  Wanderer wanderer(hierarchy, seed);
  for (int i = 0; i < 400; ++i) {
    const View view = i % 20 == 0 ? specialView(hierarchy, rng) : wanderer.next();
    CutDelta delta;
    ASSERT_TRUE(adapter.adapt(view, kNoLimit, source, adapt_scratch, delta));
    if (i % 5 == 0) adapter.validate();
    ASSERT_TRUE(refine(hierarchy, view, kNoLimit, scratch, expected));
    ASSERT_EQ(adapter.section(), expected) << "step " << i;
    ASSERT_EQ(apply(held, delta), expected) << "step " << i;
    held = expected;
  }
}
INSTANTIATE_TEST_SUITE_P(Sparse, GlobeSections, testing::Values(0, 5));

// A point of the ground on the near side of the planet that a segment from the eye reaches.
TEST(GlobeHorizon, HidesNoGroundThatCanBeSeen) {
  Rng rng(test::randomSeed());
  const Hierarchy hierarchy(test::makeGlobeScene(5, 3));
  const Frame& frame = hierarchy.frame().transform().frame();
  const double a = frame.semi_major_m, b = frame.semiMinor(), ceiling_m = hierarchy.domain().ceiling_m;
  const Spheroid& body = hierarchy.frame().transform().spheroid();
  size_t hidden = 0, seen = 0;
  for (int round = 0; round < 300; ++round) {
    View view = specialView(hierarchy, rng);
    const Metric metric = hierarchy.domain().metric(view);
    for (int i = 0; i < 100; ++i) {
      const glm::dvec3 to(rng.uniform(-1, 1), rng.uniform(-1, 1), rng.uniform(-1, 1));
      const glm::dvec3 p = body.position(to, rng.uniform(frame.floor(), ceiling_m));
      const double radius = rng.below(2) == 0 ? 0 : rng.uniform(0, 3000);
      const glm::dvec3 w = p - view.pose.eye;
      const bool is_hidden = metric.horizon().hides(metric.frustum().toView(w.x, w.y, w.z), radius);
      hidden += is_hidden;
      if (!is_hidden) continue;
      // Any ground in the sphere, from anywhere in the region: does the segment enter the spheroid of the lowest
      // ground?
      const glm::dvec3 off(rng.uniform(-1, 1), rng.uniform(-1, 1), rng.uniform(-1, 1)),
          aside(rng.uniform(-1, 1), rng.uniform(-1, 1), rng.uniform(-1, 1));
      const Spheroid::Place end_place = body.place(p + glm::normalize(off) * radius);
      const glm::dvec3 eye = view.pose.eye + glm::normalize(aside) * view.region_radius_m,
                       end = body.position(end_place.normal, std::clamp(end_place.height_m, frame.floor(), ceiling_m));
      double least = 1e9;
      for (int k = 0; k <= 2000; ++k) {
        const glm::dvec3 q = glm::mix(eye, end, k / 2000.0);
        least = std::min(least, std::sqrt(q.x * q.x / (a * a) + q.y * q.y / (a * a) + q.z * q.z / (b * b)));
      }
      const double floor = 1 + frame.floor() / b;
      ASSERT_LT(least, std::min(1.0, floor + 1e-3));
      seen += least < 1;
    }
  }
  EXPECT_GT(hidden, 1000u);
  EXPECT_EQ(hidden, seen);
}

// Where no ground is higher than the ceiling, wide spheres behind the horizon need not be needed (horizon.h).
TEST(GlobeHorizon, SparesWideSpheresByTheCeiling) {
  Rng rng(test::randomSeed());
  const Hierarchy hierarchy(test::makeGlobeScene(7, 3));
  const TerrainDomain without(hierarchy.grid(), hierarchy.frame().transform().frame());
  RefineScratch scratch;
  Section section, unlimited;
  size_t all = 0, left = 0;
  for (int i = 0; i < 30; ++i) {
    const View view = specialView(hierarchy, rng);
    ASSERT_TRUE(refine(hierarchy, view, kNoLimit, scratch, section));
    ASSERT_TRUE(refine(without, hierarchy.nodes(), view, kNoLimit, scratch, unlimited));
    EXPECT_TRUE(std::ranges::includes(unlimited.slots, section.slots));
    all += unlimited.slots.size(), left += section.slots.size();
  }
  EXPECT_LT(20 * left, 19 * all);
}

// The claim of Horizon::slack(): nothing changes while the eye moves by less.
TEST(GlobeHorizon, ResultsLastAsLongAsTheirSlack) {
  Rng rng(test::randomSeed());
  const Hierarchy hierarchy(test::makeGlobeScene(4, 3));
  size_t lasting = 0, changed = 0;
  for (int round = 0; round < 20'000; ++round) {
    View view = specialView(hierarchy, rng);
    const glm::dvec3 to(rng.uniform(-1, 1), rng.uniform(-1, 1), rng.uniform(-1, 1));
    const glm::dvec3 p = hierarchy.frame().transform().spheroid().position(to, rng.uniform(-100, 500));
    const double radius = rng.uniform(0, 1000);
    const auto hides = [&](const Metric& metric) {
      const glm::dvec3 w = p - metric.eye();
      return metric.horizon().hides(metric.frustum().toView(w.x, w.y, w.z), radius);
    };
    const Metric before = hierarchy.domain().metric(view);
    const glm::dvec3 w = p - view.pose.eye;
    const double slack = before.horizon().slack(before.frustum().toView(w.x, w.y, w.z), radius);
    ASSERT_GE(slack, 0);
    const glm::dvec3 aside(rng.uniform(-1, 1), rng.uniform(-1, 1), rng.uniform(-1, 1));
    const double share = rng.uniform(0, 1);
    view.pose.eye += glm::normalize(aside) * (0.999 * slack * share);
    view.region_radius_m = std::max(0.0, view.region_radius_m + rng.uniform(-1, 1) * 0.999 * slack * (1 - share));
    ASSERT_EQ(hides(hierarchy.domain().metric(view)), hides(before)) << "round " << round;
    lasting += slack > 10;
    view.pose.eye += glm::normalize(aside) * (20 * slack + 1);
    changed += hides(hierarchy.domain().metric(view)) != hides(before);
  }
  EXPECT_GT(lasting, 5000u);
  EXPECT_GT(changed, 100u);
}

}  // namespace
}  // namespace foreland::proto
