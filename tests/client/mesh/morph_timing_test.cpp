// How long transitions take: the laws that the header states.
#include "client/mesh/weights/morph_timing.h"

#include <gtest/gtest.h>

#include "base/rng.h"

namespace foreland::client {
namespace {

// Looks along x from the origin, 90 degrees high and wide.
proto::View ahead() {
  proto::View view;
  view.pose.orientation = proto::lookAlong({1, 0, 0}, {0, 0, 1});
  view.lens = {1.5707963267948966, 1000, 1000};
  return view;
}

MeshSpan span(Motion motion = {}) { return {Blend::kGeomorph, ahead(), motion, 0.1}; }

double intervals(const MeshSpan& s, const glm::dvec3& centre, double radius_m) {
  return MorphTiming(s, s.from, s.motion.metres_per_s).intervals(centre, radius_m);
}

TEST(MorphTiming, IsOneIntervalForKeyframes) {
  MeshSpan s = span({500, 2});
  s.blend = Blend::kKeyframe;
  EXPECT_EQ(intervals(s, {100, 0, 0}, 10), 1);
  EXPECT_EQ(intervals(s, {-100, 0, 0}, 10), 1);
}

TEST(MorphTiming, TakesASecondAtRest) {
  EXPECT_DOUBLE_EQ(intervals(span(), {100, 0, 0}, 10), 10);
  EXPECT_DOUBLE_EQ(intervals(span(), {1e6, 0, 0}, 10), 10);
}

TEST(MorphTiming, IsOverBeforeTheEyeHasComeNearOrTurnedFar) {
  const uint64_t seed = testing::UnitTest::GetInstance()->random_seed();
  SCOPED_TRACE("seed " + std::to_string(seed));
  Rng rng(seed);
  for (int i = 0; i < 1000; ++i) {
    const double r = std::pow(10, rng.uniform(0, 5));
    const Motion motion{std::pow(10, rng.uniform(-2, 3)), std::pow(10, rng.uniform(-3, 1))};
    const double n = intervals(span(motion), {r, 0, 0}, 0), seconds = n * 0.1;
    ASSERT_GE(n, 1);
    ASSERT_LE(n, 10);
    if (n == 1) continue;
    ASSERT_LE(seconds * motion.metres_per_s, MorphTiming::kMoved * r * (1 + 1e-12));
    ASSERT_LE(seconds * motion.radians_per_s, MorphTiming::kTurned_rad * (1 + 1e-12));
    ASSERT_LE(intervals(span({2 * motion.metres_per_s, motion.radians_per_s}), {r, 0, 0}, 0), n);
    ASSERT_GE(intervals(span(motion), {2 * r, 0, 0}, 0), n);
  }
}

TEST(MorphTiming, IsAJumpOutsideTheViewFromAnywhereInItsRegion) {
  EXPECT_EQ(intervals(span(), {-100, 0, 0}, 10), 0);
  EXPECT_EQ(intervals(span(), {100, 120, 0}, 10), 0);
  EXPECT_GT(intervals(span(), {100, 120, 0}, 15), 0) << "its sphere reaches into the view";
  MeshSpan s = span();
  s.from.region_radius_m = 10;
  EXPECT_GT(intervals(s, {100, 120, 0}, 10), 0) << "the eye may move there";
  s.from.region_radius_m = 0, s.from.region_angle_rad = 0.2;
  EXPECT_GT(intervals(s, {100, 120, 0}, 10), 0) << "the eye may turn there";
}

TEST(MorphTiming, IsAJumpForTheFirstSection) {
  MeshSpan s = span();
  s.is_first = true;
  for (Blend blend : {Blend::kKeyframe, Blend::kGeomorph}) {
    s.blend = blend;
    EXPECT_EQ(intervals(s, {100, 0, 0}, 10), 0);
  }
}

TEST(Motion, IsThatBetweenTwoViews) {
  proto::View a = ahead(), b = a;
  b.pose.eye = {3, 4, 0};
  b.pose.orientation = proto::lookAlong({0, 1, 0}, {0, 0, 1});
  const Motion m = Motion::between(a, b, Duration::milliseconds(500));
  EXPECT_DOUBLE_EQ(m.metres_per_s, 10);
  EXPECT_NEAR(m.radians_per_s, 3.14159265, 1e-6);
  EXPECT_EQ(Motion::between(a, b, {}).metres_per_s, 0);
}

}  // namespace
}  // namespace foreland::client
