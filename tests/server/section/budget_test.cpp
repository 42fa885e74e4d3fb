// The control of the tolerance against a viewer whose triangles and bytes follow the tolerance.
#include "server/section/budget.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace foreland::server {
namespace {

constexpr double kInterval_s = 0.2;

// Terrain: triangles fall as tau^-1.2, bytes as tau^-1.
double trianglesAt(double tau_px) { return 20'000 * std::pow(tau_px, -1.2); }
double bytesPerSecondAt(double tau_px) { return 4'000 / tau_px; }

double run(ToleranceControl& control, double wanted_px, const Budget& budget, int keyframes) {
  double tau_px = 0;
  for (int i = 0; i < keyframes; ++i) {
    tau_px = control.next(wanted_px, budget);
    control.observe(trianglesAt(tau_px), bytesPerSecondAt(tau_px) * kInterval_s, kInterval_s);
  }
  return tau_px;
}

TEST(ToleranceControl, GivesWhatIsWantedWithoutABudget) {
  ToleranceControl control;
  EXPECT_EQ(run(control, 0.75, {}, 1), 0.75);
  EXPECT_EQ(run(control, 0.75, {}, 50), 0.75);
}

TEST(ToleranceControl, NeverGoesBelowWhatIsWanted) {
  ToleranceControl control;
  for (int i = 0; i < 100; ++i)
    EXPECT_GE(run(control, 1.5, {.triangles = 50'000, .bytes_per_second = 900'000}, 1), 1.5);
}

TEST(ToleranceControl, SettlesBelowTheTriangleBudgetAndUsesMostOfIt) {
  for (const uint32_t budget : {1'000u, 5'000u, 15'000u}) {
    ToleranceControl control;
    const double triangles = trianglesAt(run(control, 0.5, {.triangles = budget}, 200));
    EXPECT_LE(triangles, budget);
    EXPECT_GE(triangles, 0.85 * budget);
  }
}

TEST(ToleranceControl, SettlesBelowTheByteBudgetAndUsesHalfOfItAtLeast) {
  ToleranceControl control;
  run(control, 0.5, {.bytes_per_second = 1'000}, 300);
  for (int i = 0; i < 100; ++i) {
    const double rate = bytesPerSecondAt(run(control, 0.5, {.bytes_per_second = 1'000}, 1));
    EXPECT_LE(rate, 1'000);
    EXPECT_GE(rate, 500);
  }
}

TEST(ToleranceControl, ObeysTheTighterOfTwoBudgets) {
  ToleranceControl control;
  const double tau_px = run(control, 0.5, {.triangles = 15'000, .bytes_per_second = 400}, 300);
  EXPECT_LE(bytesPerSecondAt(tau_px), 400);
  EXPECT_LE(trianglesAt(tau_px), 15'000);
}

TEST(ToleranceControl, ReturnsToWhatIsWantedWhenTheBudgetEnds) {
  ToleranceControl control;
  EXPECT_GT(run(control, 1, {.triangles = 2'000}, 100), 2);
  EXPECT_EQ(run(control, 1, {}, 100), 1);
}

// 8 percent of the tolerance's logarithm for each keyframe: no viewer sees a jump.
TEST(ToleranceControl, TakesBoundedSteps) {
  ToleranceControl control;
  double before_px = run(control, 0.5, {}, 1);
  for (int i = 0; i < 200; ++i) {
    const bool is_tight = i / 40 % 2 == 0;
    const double tau_px = run(control, 0.5, {.triangles = is_tight ? 500u : 0u}, 1);
    EXPECT_LE(std::fabs(std::log(tau_px / before_px)), 0.08 + 1e-12);
    before_px = tau_px;
  }
}

TEST(ToleranceControl, ContinuesFromAForcedTolerance) {
  ToleranceControl control;
  run(control, 1, {.triangles = 2'000}, 1);
  control.force(9);
  EXPECT_NEAR(std::log(run(control, 1, {.triangles = 2'000}, 1) / 9), 0, 0.08 + 1e-12);
}

// What a search in small steps would find, with few calls.
TEST(RaiseUntil, FindsTheFirstRiseThatFits) {
  for (const double factor : {1.15, 1.3, 2.0})
    for (const double limit_px : {0.0, 0.25, 0.2876, 1.0, 31.0, 5e4, 1e5}) {
      float expected = 0.25f;
      while (expected < limit_px) expected = static_cast<float>(expected * factor);
      int calls = 0;
      const auto fits = [&](double tau_px) { return ++calls, tau_px >= limit_px; };
      EXPECT_EQ(raiseUntil(0.25, factor, fits), expected) << factor << ", " << limit_px;
      EXPECT_LE(calls, 17);
      if (limit_px <= 0.25) { EXPECT_EQ(calls, 1); }
    }
}

TEST(RaiseUntil, EndsThoughNothingFits) {
  int calls = 0;
  EXPECT_EQ(raiseUntil(0.01, 1.15, [&](double) { return ++calls, false; }), kMostTolerance_px);
  EXPECT_LE(calls, 17);
}

}  // namespace
}  // namespace foreland::server
