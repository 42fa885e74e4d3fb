// Angles between orientations, and cameras that look along a direction.
#include "proto/space/pose.h"

#include <gtest/gtest.h>

#include <glm/geometric.hpp>
#include <string>

#include "base/rng.h"

namespace foreland::proto {
namespace {

constexpr double kPi = 3.14159265358979323846;

uint64_t newSeed() { return static_cast<uint64_t>(testing::UnitTest::GetInstance()->random_seed()); }

glm::dvec3 randomUnit(Rng& rng) {
  for (;;) {
    const glm::dvec3 v(rng.uniform(-1, 1), rng.uniform(-1, 1), rng.uniform(-1, 1));
    if (glm::length(v) > 0.1 && glm::length(v) < 1) return glm::normalize(v);
  }
}
glm::dquat randomRotation(Rng& rng) { return glm::angleAxis(rng.uniform(-kPi, kPi), randomUnit(rng)); }

// A rotation by a known angle, from the smallest to a half turn.
TEST(AngleBetween, IsAnUpperBoundWithinItsStatedError) {
  const uint64_t seed = newSeed();
  Rng rng(seed);
  for (int i = 0; i < 20000; ++i) {
    const double angle = std::min(kPi, std::pow(10, rng.uniform(-12, 0.5)));
    const glm::dquat a(1, 0, 0, 0), b = glm::angleAxis(angle, randomUnit(rng));
    const double got = angleBetween(a, b);
    // The axis is a unit vector but for two ulp, and near a half turn the sine hardly tells angles apart.
    const double rounding = 4e-16 * angle + (angle > 3 ? 1e-7 : 0);
    ASSERT_GE(got, angle - rounding) << "seed " << seed << ", angle " << angle;
    ASSERT_LE(got, angle * (1 + 1e-12) + 1e-15 + rounding + 1e-15 * angle / std::max(1e-3, kPi - angle))
        << "seed " << seed << ", angle " << angle;
  }
}

TEST(AngleBetween, DoesNotDependOnOrderOrOnTheFrame) {
  const uint64_t seed = newSeed();
  Rng rng(seed);
  for (int i = 0; i < 2000; ++i) {
    const glm::dquat a = randomRotation(rng), b = randomRotation(rng), c = randomRotation(rng);
    const double angle = angleBetween(a, b);
    // Near a half turn the sine is flat: a rounding of 1e-16 in it is one of 1e-8 in the angle.
    ASSERT_NEAR(angleBetween(b, a), angle, 1e-7) << "seed " << seed;
    ASSERT_NEAR(angleBetween(c * a, c * b), angle, 1e-7) << "seed " << seed;
    ASSERT_NEAR(angleBetween(a, -b), angle, 1e-7) << "seed " << seed;  // the same orientation
  }
}

// No direction turns by more than the angle: what the refinement test takes it for.
TEST(AngleBetween, BoundsTheTurnOfEveryDirection) {
  const uint64_t seed = newSeed();
  Rng rng(seed);
  for (int i = 0; i < 5000; ++i) {
    const glm::dquat a = randomRotation(rng);
    const glm::dquat b = a * glm::angleAxis(std::pow(10, rng.uniform(-6, 0.4)), randomUnit(rng));
    const glm::dvec3 direction = randomUnit(rng), from = a * direction, to = b * direction;
    const double turned = 2 * std::asin(std::min(1.0, 0.5 * glm::distance(from, to)));
    ASSERT_LE(turned, angleBetween(a, b) + 2e-15) << "seed " << seed;
  }
}

TEST(LookAlong, LooksThereWithUpAsNearAsMayBe) {
  const uint64_t seed = newSeed();
  Rng rng(seed);
  for (int i = 0; i < 2000; ++i) {
    const glm::dvec3 forward = randomUnit(rng), up = i % 10 == 0 ? forward : randomUnit(rng);
    const Pose pose{{}, lookAlong(forward, up)};
    ASSERT_TRUE(isUsable(pose)) << "seed " << seed;
    ASSERT_LT(glm::distance(pose.forward(), forward), 1e-12) << "seed " << seed;
    // Up lies in the plane of both, on the side of `up`.
    ASSERT_LT(std::fabs(glm::dot(pose.right(), up)), 1e-6) << "seed " << seed;
    ASSERT_GT(glm::dot(pose.up(), up), -1e-6) << "seed " << seed;
  }
}

TEST(Interpolate, HasItsEndsAndGoesEvenly) {
  const uint64_t seed = newSeed();
  Rng rng(seed);
  for (int i = 0; i < 1000; ++i) {
    const Pose a{randomUnit(rng) * 1e3, randomRotation(rng)}, b{randomUnit(rng) * 1e3, randomRotation(rng)};
    const double weight = rng.uniform(0, 1);
    const Pose at = interpolate(a, b, weight);
    ASSERT_EQ(interpolate(a, b, 0).eye, a.eye);
    ASSERT_LT(glm::distance(interpolate(a, b, 1).eye, b.eye), 1e-9);
    ASSERT_NEAR(glm::distance(a.eye, at.eye), weight * glm::distance(a.eye, b.eye), 1e-9) << "seed " << seed;
    ASSERT_NEAR(angleBetween(a.orientation, at.orientation), weight * angleBetween(a.orientation, b.orientation), 1e-7)
        << "seed " << seed;
  }
}

}  // namespace
}  // namespace foreland::proto
