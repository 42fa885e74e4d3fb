// Error shapes and packed records against their definitions; surfaces from formulas lie where they should.
#include "terrain/surface/shapes.h"

#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>
#include <limits>
#include <numbers>
#include <string>

#include "base/rng.h"
#include "proto/section/surface_bounds.h"
#include "terrain/surface/error_shape.h"

namespace foreland::terrain {
namespace {

using proto::CompactNormal;
using proto::CompactShare;
using proto::MeshRule;
using proto::NodeId;
using proto::Slot;

constexpr ErrorShape kKinds[] = {ErrorShape::kSpheroid, ErrorShape::kHoppe};

glm::dvec3 direction(Rng& rng) {
  glm::dvec3 v;
  do v = {rng.uniform(-1, 1), rng.uniform(-1, 1), rng.uniform(-1, 1)};
  while (glm::length(v) > 1 || glm::length(v) < 0.1);
  return glm::normalize(v);
}

// How far a shape about z reaches in a direction at `angle` from z: the definition of either shape.
double reach(ErrorShape kind, const Extent& shape, double angle) {
  const double c = std::fabs(std::cos(angle)), s = std::fabs(std::sin(angle));
  return kind == ErrorShape::kHoppe ? std::max(shape.across, shape.along * c)
                                    : std::hypot(shape.along * c, shape.across * s);
}

// A point is inside a convex body if in no direction it lies beyond the body's reach.
double gaugeByReach(ErrorShape kind, const Extent& shape, const Extent& e) {
  double most = 0;
  for (double angle = 0; angle <= std::numbers::pi / 2 + 1e-9; angle += 1e-4)
    most = std::max(most, (e.along * std::cos(angle) + e.across * std::sin(angle)) / reach(kind, shape, angle));
  return most;
}

TEST(ErrorShapes, GaugeIsTheFactorUntilTheShapeTouches) {
  Rng rng(1);
  for (ErrorShape kind : kKinds)
    for (int i = 0; i < 40; ++i) {
      const Extent shape{rng.uniform(0.01, 2), rng.uniform(0.01, 2)}, e{rng.uniform(0, 2), rng.uniform(0, 2)};
      EXPECT_NEAR(gauge(kind, shape, e), gaugeByReach(kind, shape, e), 2e-4 * gauge(kind, shape, e));
    }
  EXPECT_EQ(gauge(ErrorShape::kSpheroid, {1, 0}, {0.5, 0}), 0.5);
  EXPECT_EQ(gauge(ErrorShape::kHoppe, {0, 0}, {0, 0}), 0);
  EXPECT_EQ(gauge(ErrorShape::kSpheroid, {1, 0}, {0, 0.1}), std::numeric_limits<double>::infinity());
}

TEST(ErrorShapes, HoldTheirErrorsAndAreNoLargerThanByTheLargest) {
  for (uint64_t seed = 1; seed <= 200; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    Rng rng(seed);
    std::vector<Extent> errors(1 + rng.below(30));
    const double flat = std::pow(10, rng.uniform(-4, 1));
    for (Extent& e : errors) e = {rng.uniform(), flat * rng.uniform()};
    for (ErrorShape kind : kKinds) {
      const Extent by_largest = boundingShapeByLargest(kind, errors);
      std::vector<Extent> thinned = errors;
      const Extent smallest = boundingShape(kind, thinned);
      EXPECT_LE(meanRadius(kind, smallest), meanRadius(kind, by_largest) * 1.001);
      for (const Extent& e : errors) {
        EXPECT_LE(gauge(kind, smallest, e), 1 + 1e-12);
        EXPECT_LE(gauge(kind, by_largest, e), 1 + 1e-12);
      }
    }
  }
}

// S figure 4: one error 15 degrees from the normal. Its length is 1; the shapes by S's and Hoppe's ratios are longer.
TEST(ErrorShapes, OfOneErrorAreHardlyLongerThanIt) {
  const double angle = 15 * std::numbers::pi / 180;
  std::vector<Extent> one{{std::cos(angle), std::sin(angle)}};
  EXPECT_NEAR(boundingShapeByLargest(ErrorShape::kSpheroid, one).along, std::sqrt(2) * std::cos(angle), 1e-12);
  EXPECT_GT(boundingShapeByLargest(ErrorShape::kHoppe, one).along, 1.9 * std::cos(angle));
  EXPECT_LT(boundingShape(ErrorShape::kSpheroid, one).along, 1.25);
  EXPECT_LT(meanRadius(ErrorShape::kSpheroid, boundingShape(ErrorShape::kSpheroid, one)),
            meanRadius(ErrorShape::kHoppe, boundingShape(ErrorShape::kHoppe, one)));
}

TEST(ErrorShapes, OfNothingAreNothing) {
  std::vector<Extent> none, zeros{{0, 0}, {0, 0}}, line{{0, 1}, {0, 2}};
  for (ErrorShape kind : kKinds) {
    EXPECT_EQ(boundingShape(kind, none).along, 0);
    EXPECT_EQ(boundingShape(kind, zeros).across, 0);
    EXPECT_GE(boundingShape(kind, line).across, 2);
    EXPECT_EQ(boundingShapeByLargest(kind, none).along, 0);
  }
}

TEST(ErrorShapes, MeanRadiusIsTheMeanOverAllDirections) {
  for (ErrorShape kind : kKinds)
    for (const Extent& shape : {Extent{1, 0.01}, {1, 0.5}, {1, 1}, {0.3, 1}}) {
      double sum = 0;
      constexpr int kSteps = 20000;
      for (int i = 0; i < kSteps; ++i) {  // cosines of the angle between normal and eye are spread evenly
        const double c = (i + 0.5) / kSteps, s = std::sqrt(1 - c * c);
        const double a = shape.along, b = shape.across;
        const double seen = kind == ErrorShape::kHoppe ? std::max(b, a * s) : std::max(b, std::hypot(a * s, b * c));
        sum += seen * seen;
      }
      EXPECT_NEAR(meanRadius(kind, shape), std::sqrt(sum / kSteps), 1e-3);
    }
}

TEST(ErrorShapes, GrowUntilTheyHoldOthers) {
  for (uint64_t seed = 1; seed <= 100; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    Rng rng(seed);
    const glm::dvec3 n(0, 0, 1), m = direction(rng);
    const Extent shape{rng.uniform(0.1, 1), rng.uniform(0.1, 1)};
    for (ErrorShape kind : kKinds) {
      Extent other{rng.uniform(0.1, 1), rng.uniform(0.1, 1)};
      if (kind == ErrorShape::kHoppe) other.along = std::max(other.along, other.across);
      const double growth = growthToHold(kind, shape, n, other, m);
      double least = 0;
      for (int i = 0; i < 3000; ++i) {
        const glm::dvec3 u = direction(rng);
        const auto reachOf = [&](const Extent& e, const glm::dvec3& axis) {
          return reach(kind, e, std::acos(std::clamp(glm::dot(axis, u), -1.0, 1.0)));
        };
        least = std::max(least, reachOf(other, m) / reachOf(shape, n));
      }
      EXPECT_GE(growth, least);
      EXPECT_LE(growth, least * 1.05);
    }
  }
}

TEST(SurfaceRecords, PackNormalsToSevenHundredThousandthsOfARadian) {
  Rng rng(3);
  for (int i = 0; i < 20000; ++i) {
    const glm::dvec3 n = direction(rng);
    EXPECT_LT(glm::length(CompactNormal::pack(n).unpack() - n), 7e-5);
  }
  for (const glm::dvec3& n : {glm::dvec3(0, 0, 1), {0, 0, -1}, {1, 0, 0}, {0, -1, 0}})
    EXPECT_LT(glm::length(CompactNormal::pack(n).unpack() - n), 1e-12);
}

TEST(SurfaceRecords, RoundSharesUp) {
  Rng rng(4);
  for (int i = 0; i < 20000; ++i) {
    const double share = std::pow(rng.uniform(), 4), packed = CompactShare::roundUp(share).value();
    EXPECT_GE(packed, share);
    EXPECT_LE(std::sqrt(packed), std::sqrt(share) + 1.001 / 255);
  }
  EXPECT_EQ(CompactShare::roundUp(0).value(), 0);
  EXPECT_TRUE(CompactShare::roundUp(1).isFull());
  EXPECT_TRUE(CompactShare::roundUp(std::numeric_limits<double>::quiet_NaN()).isFull());
}

TEST(Shapes, PutEveryVertexOnTheSurface) {
  for (MeshRule rule : {MeshRule::kQuadrisection, MeshRule::kBisection}) {
    const TrueSurface sphere = *makeSphere(2, {rule, 4, 1e-6}), torus = *makeTorus({3, 1, 9, 5}, {rule, 3, 1e-6});
    forEachNode(sphere.topology, [&](NodeId n, Slot) { EXPECT_NEAR(glm::length(sphere.position(n)), 2, 2e-6); });
    forEachNode(torus.topology, [&](NodeId n, Slot) {
      const glm::dvec3 p = torus.position(n);
      EXPECT_NEAR(std::hypot(std::hypot(p.x, p.y) - 3, p.z), 1, 2e-6);
    });
  }
}

TEST(Shapes, AreRefusedWithTheReason) {
  EXPECT_FALSE(makeSphere(0, {}).ok());
  EXPECT_FALSE(makeSphere(1, {MeshRule::kQuadrisection, 40, 1e-6}).ok());
  EXPECT_FALSE(makeTorus({1, 2, 8, 8}, {}).ok());
  EXPECT_FALSE(makeTorus({2, 1, 2, 8}, {}).ok());
  EXPECT_FALSE(makeSphere(1, {MeshRule::kQuadrisection, 2, 0}).ok());
  const auto huge = makeSphere(1e9, {MeshRule::kQuadrisection, 2, 1e-3});
  ASSERT_FALSE(huge.ok());
  EXPECT_NE(huge.error().message.find("base vertex 0"), std::string::npos) << huge.error().message;
  auto topology = *proto::MeshTopology::create({MeshRule::kQuadrisection, 1, 3, {{0, 1, 2}}});
  const auto nan = makeSurface(std::move(topology), 1, {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}},
                               [](NodeId, const glm::dvec3&) { return glm::dvec3(std::nan("")); });
  ASSERT_FALSE(nan.ok());
  EXPECT_NE(nan.error().message.find("node 0"), std::string::npos) << nan.error().message;
}

}  // namespace
}  // namespace foreland::terrain
