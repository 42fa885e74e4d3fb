// The surface oracle on frames whose errors are known, and its verdict on refined surfaces: the error guarantee (THEORY
// section 3) for every vertex of every kind of surface.
#include "oracle/surface/surface_oracle.h"

#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>
#include <string>

#include "oracle/reference/plain_surface.h"
#include "oracle/surface/surface_truth.h"
#include "terrain/surface/bounds.h"
#include "tests/support/surface_views.h"
#include "tests/support/surfaces.h"

namespace foreland::oracle {
namespace {

using proto::ErrorShape;
using proto::MeshRule;
using proto::SurfaceTest;
using proto::View;
using terrain::TrueSurface;
using test::kScreen;
using test::lookAt;

PlainSection everything(const TrueSurface& surface) {
  return {std::vector<uint8_t>(surface.topology.slotCount(), 1), surface.topology.slotCount()};
}

TEST(SurfaceOracleKnows, ThatTheFullSurfaceHasNoError) {
  for (MeshRule rule : {MeshRule::kQuadrisection, MeshRule::kBisection})
    for (const test::NamedSurface& named : test::surfaces(rule, 3)) {
      SCOPED_TRACE(named.name);
      const SurfaceOracle oracle(truthOf(named.surface));
      const auto verdict =
          oracle.judge(drawnTriangles(named.surface, everything(named.surface)), lookAt({4, 3, 2}, {0, 0, 0}), kScreen);
      EXPECT_LT(verdict.max_m, 1e-12);
      EXPECT_LT(verdict.silhouette.max_px, 1e-9);
      EXPECT_LT(verdict.interior.max_px, 1e-9);
      EXPECT_EQ(verdict.uncovered, 0u);
      EXPECT_GT(verdict.silhouette.vertices + verdict.interior.vertices, 0u);
    }
}

// One flat square of two triangles, drawn elsewhere: by hand.
TEST(SurfaceOracleKnows, WhereAVertexIsDrawn) {
  SurfaceTruth truth{{{0, {0, 0}}, {0, {4, 0}}, {0, {0, 4}}, {0, {2, 2}}},
                     {{0, -1, -1}, {0, 1, -1}, {0, -1, 1}, {0, 0, 0}},
                     {{0, 1, 3}, {0, 3, 2}},
                     false};
  const SurfaceOracle oracle(truth);
  DrawnTriangle drawn{0, {{{0, 0}, {4, 0}, {0, 4}}}, {{{0, -1, -1}, {0, 1, -1}, {0, -1, 1}}}};
  const proto::Pose pose = lookAt({10, 0, 0}, {0, 0, 0});
  EXPECT_NEAR(oracle.judge({&drawn, 1}, pose, kScreen).interior.max_px, 0, 1e-12);
  drawn.positions[1].y += 0.2;  // the vertex in the middle of its edge slides along with it, by half
  const auto slid = oracle.judge({&drawn, 1}, pose, kScreen);
  EXPECT_NEAR(slid.interior.max_px, kScreen.focalPx() * 0.2 / 10, 1e-9);
  EXPECT_NEAR(slid.max_m, 0.2, 1e-12);
  EXPECT_EQ(slid.interior.vertices, 4u);
  drawn.weights = {{{0, 0}, {2, 2}, {0, 4}}};  // half of it
  EXPECT_EQ(oracle.judge({&drawn, 1}, pose, kScreen).uncovered, 1u);
  EXPECT_EQ(oracle.judge({}, pose, kScreen).uncovered, 4u);
  EXPECT_EQ(oracle.judge({}, lookAt({-10, 0, 0}, {-20, 0, 0}), kScreen).uncovered, 0u);  // behind the eye
}

TEST(SurfaceOracleKnows, TheSilhouetteOfASphere) {
  const TrueSurface sphere = *terrain::makeSphere(1, {});
  const SurfaceOracle oracle(truthOf(sphere));
  const auto verdict =
      oracle.judge(drawnTriangles(sphere, everything(sphere)), lookAt({1000, 0, 0}, {0, 0, 0}), kScreen);
  EXPECT_NEAR(static_cast<double>(verdict.silhouette.vertices), 128, 64);  // about a great circle's worth
  EXPECT_NEAR(static_cast<double>(verdict.interior.vertices), 2049, 150);  // about half of 4,098
}

TEST(PlainRefinement, TakesExactlyTheNodesThatPass) {
  for (MeshRule rule : {MeshRule::kQuadrisection, MeshRule::kBisection}) {
    const TrueSurface torus = *terrain::makeTorus({2, 0.8, 5, 4}, {rule, 4, 1e-6});
    const auto records = terrain::computeBounds(torus);
    for (uint64_t seed = 1; seed <= 20; ++seed) {
      SCOPED_TRACE("seed " + std::to_string(seed));
      Rng rng(seed);
      View view;
      SurfaceTest test;
      view.pose = lookAt({rng.uniform(-9, 9), rng.uniform(-9, 9), rng.uniform(1, 9)}, {0, 0, 0});
      view.tau_px = rng.uniform(0.2, 3);
      test.interior_px = rng.uniform(3, 10);
      const proto::SurfaceMetric metric(view, test);
      const PlainSection section = plainRefine(torus, records, metric);
      size_t nodes = 0;
      terrain::forEachNode(torus.topology, [&](proto::NodeId, proto::Slot slot) {
        EXPECT_EQ(section.active[slot] != 0, metric.passes(proto::SurfaceBounds::of(records[slot], torus.quantum_m)));
        nodes += section.active[slot];
      });
      EXPECT_EQ(section.nodes, nodes);
    }
  }
}

class ErrorGuarantee : public testing::TestWithParam<std::tuple<MeshRule, ErrorShape>> {};

// No vertex is drawn farther from its true position than the tolerance there, from anywhere in the region of the view
// and however the eye has turned in it.
TEST_P(ErrorGuarantee, HoldsForEveryVertexAndEveryEyeInTheRegion) {
  const auto& [rule, kind] = GetParam();
  uint64_t judged = 0;
  double nearest = 0;  // to the tolerance, as a share of it: a bound that nothing comes near is not tested
  for (const test::NamedSurface& named : test::surfaces(rule, 4)) {
    SCOPED_TRACE(named.name);
    const SurfaceOracle oracle(truthOf(named.surface));
    const auto records = terrain::computeBounds(named.surface, {.shape = kind, .threads = 1});
    for (uint64_t seed = 1; seed <= 12; ++seed) {
      SCOPED_TRACE("seed " + std::to_string(seed));
      Rng rng(seed);
      auto [view, test] = test::anySurfaceView(rng, named.is_closed);
      test.shape = kind;
      const auto section = plainRefine(named.surface, records, proto::SurfaceMetric(view, test));
      const auto drawn = drawnTriangles(named.surface, section);
      for (int i = 0; i < 4; ++i) {
        const auto verdict = oracle.judge(drawn, test::anyPoseOf(view, rng), kScreen, test.nearest_m);
        EXPECT_LE(verdict.silhouette.max_px, view.tau_px);
        EXPECT_LE(verdict.interior.max_px, test.interior_px);
        EXPECT_EQ(verdict.uncovered, 0u);
        judged += verdict.silhouette.vertices + verdict.interior.vertices;
        nearest =
            std::max({nearest, verdict.silhouette.max_px / view.tau_px, verdict.interior.max_px / test.interior_px});
      }
    }
  }
  EXPECT_GT(judged, 10'000u);
  EXPECT_GT(nearest, 0.5);
}

// Where the shape's long axis points at the eye, only the support's extent shows the error.
TEST_P(ErrorGuarantee, HoldsRightAboveEveryNode) {
  const auto& [rule, kind] = GetParam();
  for (const test::NamedSurface& named : test::surfaces(rule, 3)) {
    SCOPED_TRACE(named.name);
    const TrueSurface& surface = named.surface;
    const SurfaceOracle oracle(truthOf(surface));
    const auto records = terrain::computeBounds(surface, {.shape = kind, .threads = 1});
    Rng rng(1);
    uint64_t judged = 0;
    terrain::forEachNode(surface.topology, [&](proto::NodeId n, proto::Slot slot) {
      const proto::SurfaceBounds bounds = proto::SurfaceBounds::of(records[slot], surface.quantum_m);
      View view;
      SurfaceTest test;
      view.pose =
          lookAt(surface.position(n) + bounds.normal() * (bounds.radius * rng.uniform(1.1, 5)), surface.position(n));
      view.lens = kScreen;
      view.tau_px = test.interior_px = std::pow(10, rng.uniform(0, 2));
      test.nearest_m = 1e-3;
      test.is_closed = named.is_closed;
      test.shape = kind;
      const auto section = plainRefine(surface, records, proto::SurfaceMetric(view, test));
      const auto verdict = oracle.judge(drawnTriangles(surface, section), view.pose, kScreen, test.nearest_m);
      EXPECT_LE(std::max(verdict.silhouette.max_px, verdict.interior.max_px), test.interior_px);
      judged += verdict.silhouette.vertices + verdict.interior.vertices;
    });
    EXPECT_GT(judged, 100u);
  }
}

INSTANTIATE_TEST_SUITE_P(Kinds, ErrorGuarantee,
                         testing::Combine(testing::Values(MeshRule::kQuadrisection, MeshRule::kBisection),
                                          testing::Values(ErrorShape::kSpheroid, ErrorShape::kHoppe)));

// S, section 4: the sphere of 8,192 faces needs no more than 732 at 0.5 and 3.5 pixels, the whole of it in view.
TEST(PaperSphere, NeedsNoMoreFacesThanThePaperSays) {
  const TrueSurface sphere = *terrain::makeSphere(1, {});
  const auto records = terrain::computeBounds(sphere);
  const SurfaceOracle oracle(truthOf(sphere));
  EXPECT_EQ(countTriangles(sphere, everything(sphere)), 8192u);
  for (uint64_t seed = 1; seed <= 40; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    Rng rng(seed);
    View view;
    SurfaceTest test;
    view.pose = lookAt(glm::normalize(test::anyPoint(rng)) * 3.02, {0, 0, 0});  // a disc of 60 % of the screen's height
    view.lens = kScreen;
    view.tau_px = 0.5;
    test.interior_px = 3.5;
    const auto section = plainRefine(sphere, records, proto::SurfaceMetric(view, test));
    EXPECT_LE(countTriangles(sphere, section), 732u);
    const auto verdict = oracle.judge(drawnTriangles(sphere, section), view.pose, kScreen);
    EXPECT_LE(verdict.silhouette.max_px, 0.5);
    EXPECT_LE(verdict.interior.max_px, 3.5);
    EXPECT_EQ(verdict.uncovered, 0u);
  }
}

}  // namespace
}  // namespace foreland::oracle
