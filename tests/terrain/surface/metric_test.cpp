// Laws of the screen tests (proto/refine/surface/surface_metric.h): monotone from child to parent, equal to the closed
// forms' definitions by sampling, and test results that hold as long as their slack says.
#include "proto/refine/surface/surface_metric.h"

#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>
#include <string>

#include "terrain/surface/bounds.h"
#include "tests/support/surfaces.h"

namespace foreland::terrain {
namespace {

using proto::CompactBound;
using proto::CompactNormal;
using proto::MeshRule;
using proto::NodeId;
using proto::Slot;
using proto::SurfaceBounds;
using proto::SurfaceMetric;
using proto::SurfaceRecord;
using proto::SurfaceTest;
using proto::View;

glm::dvec3 direction(Rng& rng) {
  glm::dvec3 v;
  do v = {rng.uniform(-1, 1), rng.uniform(-1, 1), rng.uniform(-1, 1)};
  while (glm::length(v) > 1 || glm::length(v) < 0.1);
  return glm::normalize(v);
}

// From inside the surface to far away, looking at it or past it, with or without a ball and a turn.
struct Arrangement {
  View view;
  SurfaceTest test;
};
Arrangement randomArrangement(Rng& rng, ErrorShape kind) {
  Arrangement setup;
  auto& [view, test] = setup;
  test.shape = kind;
  const double distance = std::pow(10, rng.uniform(-1, 2));
  view.pose.eye = direction(rng) * distance;
  view.pose.orientation =
      proto::lookAlong(glm::normalize(direction(rng) * (rng.uniform() * distance) - view.pose.eye), {0, 0, 1});
  view.lens = {rng.uniform(0.3, 2.0), static_cast<uint32_t>(200 + rng.below(2000)),
               static_cast<uint32_t>(200 + rng.below(1000))};
  view.tau_px = std::pow(10, rng.uniform(-1, 1));
  test.interior_px = view.tau_px * rng.uniform(1, 8);
  view.region_radius_m = rng.below(2) * rng.uniform(0, 0.3);
  view.region_angle_rad = rng.below(2) * rng.uniform(0, 0.6);
  test.nearest_m = 1e-3;
  test.is_closed = rng.below(3) > 0;
  return setup;
}

constexpr ErrorShape kKinds[] = {ErrorShape::kSpheroid, ErrorShape::kHoppe};
constexpr MeshRule kRules[] = {MeshRule::kQuadrisection, MeshRule::kBisection};

TEST(SurfaceMetricLaws, WhatPassesHasParentsThatPass) {
  uint64_t passed = 0;
  for (MeshRule rule : kRules)
    for (ErrorShape kind : kKinds)
      for (const test::NamedSurface& named : test::surfaces(rule, 4)) {
        SCOPED_TRACE(named.name);
        const proto::MeshTopology& mesh = named.surface.topology;
        const auto records = computeBounds(named.surface, {.shape = kind, .threads = 1});
        for (uint64_t seed = 1; seed <= 25; ++seed) {
          SCOPED_TRACE("seed " + std::to_string(seed));
          Rng rng(seed);
          const Arrangement setup = randomArrangement(rng, kind);
          const SurfaceMetric metric(setup.view, setup.test);
          const auto passes = [&](NodeId n) {
            return metric.passes(SurfaceBounds::of(records[mesh.slot(n)], named.surface.quantum_m));
          };
          forEachNode(mesh, [&](NodeId n, Slot) {
            if (!passes(n)) return;
            ++passed;
            for (NodeId parent : mesh.parents(n)) EXPECT_TRUE(passes(parent));
          });
        }
      }
  EXPECT_GT(passed, 10000u);
}

// The result's slack, tried out: the eye moves by less, any way.
TEST(SurfaceMetricLaws, TestResultsStandAsLongAsTheySay) {
  uint64_t flips = 0, trials = 0;
  for (ErrorShape kind : kKinds)
    for (const test::NamedSurface& named : test::surfaces(MeshRule::kQuadrisection, 3)) {
      SCOPED_TRACE(named.name);
      const auto records = computeBounds(named.surface, {.shape = kind, .threads = 1});
      for (uint64_t seed = 1; seed <= 60; ++seed) {
        SCOPED_TRACE("seed " + std::to_string(seed));
        Rng rng(seed);
        const Arrangement setup = randomArrangement(rng, kind);
        const SurfaceMetric metric(setup.view, setup.test);
        forEachNode(named.surface.topology, [&](NodeId, Slot slot) {
          const SurfaceBounds bounds = SurfaceBounds::of(records[slot], named.surface.quantum_m);
          const auto testResult = metric.testResult(bounds);
          EXPECT_EQ(testResult.passes, metric.passes(bounds));
          EXPECT_GE(testResult.slack_m, 0);
          const auto after = [&](double motion) {
            View moved = setup.view;
            moved.pose.eye += direction(rng) * motion;
            return SurfaceMetric(moved, setup.test).passes(bounds);
          };
          EXPECT_EQ(after(testResult.slack_m * 0.9999), testResult.passes);
          flips += after(testResult.slack_m * 3) != testResult.passes;
          ++trials;
        });
      }
    }
  EXPECT_GT(flips * 20, trials);  // slack is not much too small
}

// S equations 4 and 5: what the shape shows of itself to an eye far away, against all its errors.
TEST(SurfaceMetricLaws, ClosedFormsAreTheLargestProjectionOfTheShape) {
  Rng rng(5);
  for (ErrorShape kind : kKinds)
    for (int i = 0; i < 60; ++i) {
      SurfaceRecord record;
      record.normal = CompactNormal::pack(direction(rng));
      record.error_along = CompactBound::roundUp(rng.uniform(0.1, 1));
      record.error_across = CompactBound::roundUp(kind == ErrorShape::kHoppe ? rng.uniform(0.01, 0.1) : rng.uniform());
      const SurfaceBounds bounds = SurfaceBounds::of(record, 1);
      View view;
      SurfaceTest test;
      test.shape = kind;
      view.pose.eye = direction(rng) * 1e4;
      view.pose.orientation = proto::lookAlong(-glm::normalize(view.pose.eye), {0, 0, 1});
      test.is_closed = false;
      const glm::dvec3 side = glm::normalize(glm::cross(bounds.normal(), direction(rng))),
                       other = glm::cross(bounds.normal(), side);
      double largest = 0;
      for (int k = 0; k <= 100; ++k)
        for (int turn = 0; turn < 200; ++turn) {
          const double tilt = k * std::numbers::pi / 200, azimuth = turn * std::numbers::pi / 100;
          const double c = std::cos(tilt), s = std::sin(tilt);
          const double grow = gauge(kind, {bounds.along, bounds.across}, {c, s});
          const glm::dvec3 u = c * bounds.normal() + s * (std::cos(azimuth) * side + std::sin(azimuth) * other);
          largest = std::max(largest, glm::length(glm::cross(u / grow, view.pose.forward())));
        }
      const double px = view.lens.focalPx() * largest / 1e4;
      view.tau_px = test.interior_px = px * 0.999;
      EXPECT_TRUE(SurfaceMetric(view, test).passes(bounds));
      view.tau_px = test.interior_px = px * 1.002;
      EXPECT_FALSE(SurfaceMetric(view, test).passes(bounds));
    }
}

TEST(SurfaceMetricLaws, WhatFacesAwayOrLiesBesideIsNotRefined) {
  const TrueSurface sphere = *makeSphere(1, {});
  const auto records = computeBounds(sphere);
  View view;
  SurfaceTest test;
  view.pose.eye = {10, 0, 0};
  view.pose.orientation = proto::lookAlong({-1, 0, 0}, {0, 0, 1});
  view.tau_px = test.interior_px = 1e-3;
  test.nearest_m = 1e-3;
  const auto countIf = [&](const View& v, const SurfaceTest& t, const auto& where) {
    const SurfaceMetric metric(v, t);
    size_t count = 0;
    forEachNode(sphere.topology, [&](NodeId n, Slot slot) {
      count += sphere.topology.level(n) > 2 && where(sphere.position(n)) &&
               metric.passes(SurfaceBounds::of(records[slot], sphere.quantum_m));
    });
    return count;
  };
  const auto behind = [](const glm::dvec3& p) { return p.x < -0.4; };
  const auto anywhere = [](const glm::dvec3&) { return true; };
  EXPECT_EQ(countIf(view, test, behind), 0u);
  EXPECT_GT(countIf(view, test, anywhere), 1500u);
  SurfaceTest open = test;
  open.is_closed = false;
  EXPECT_GT(countIf(view, open, behind), 500u);
  View aside = view;
  aside.pose.orientation = proto::lookAlong({0, 1, 0}, {0, 0, 1});
  EXPECT_EQ(countIf(aside, test, anywhere), 0u);
}

}  // namespace
}  // namespace foreland::terrain
