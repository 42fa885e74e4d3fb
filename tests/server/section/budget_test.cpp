// The control of the tolerance against a viewer whose triangles and bytes follow the tolerance.
#include "server/section/budget.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

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

// Adaptive keyframes may be a second apart; a viewer who wants a finer picture does not wait five times as long then.
TEST(ToleranceControl, FallsAsFastWhateverTheInterval) {
  for (const double interval_s : {0.2, 0.25, 0.5, 1.0}) {
    ToleranceControl control;
    double tau_px = run(control, 4, {}, 3), passed_s = 0;
    for (; tau_px > 1; passed_s += interval_s) {
      control.observe(trianglesAt(tau_px), 100, interval_s);
      tau_px = control.next(1, {});
    }
    EXPECT_NEAR(passed_s, std::log(4) / 0.4, interval_s) << "0.4 of log tau a second, rounded up to whole keyframes";
  }
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

// After the section did not fit, the tolerance is soon back; no faster than otherwise below where it was before.
TEST(ToleranceControl, FallsFasterAfterItWasForcedUp) {
  ToleranceControl control;
  run(control, 1, {}, 1);
  control.force(30'000);
  EXPECT_LE(run(control, 1, {}, 31), 1) << "log 30,000 is 10.3, at 0.35 a keyframe";
  run(control, 1, {.triangles = 2'000}, 100);
  const double steered_px = control.tolerance();
  control.force(2 * steered_px);
  double before_px = control.tolerance();
  for (int i = 0; i < 30; ++i) {
    const double tau_px = run(control, 1, {}, 1);
    if (before_px <= steered_px) { EXPECT_LE(std::log(before_px / tau_px), 0.08 + 1e-12); }
    before_px = tau_px;
  }
}

TEST(ToleranceControl, RisesWhileProcessorsAreScarceRestsWhileTheyAreTakenAndFallsSlowly) {
  ToleranceControl control;
  run(control, 1, {}, 1);
  const double scarce_px = run(control, 1, {.processors = Processors::kScarce}, 20);
  EXPECT_NEAR(std::log(scarce_px), 20 * 0.08, 1e-9);
  EXPECT_EQ(run(control, 1, {.processors = Processors::kTaken}, 20), scarce_px);
  EXPECT_NEAR(std::log(scarce_px / run(control, 1, {}, 10)), 10 * 0.02, 1e-9);
  EXPECT_EQ(run(control, 1, {}, 200), 1);
}

TEST(ToleranceControl, BeginsAnewAfterARestart) {
  ToleranceControl control;
  run(control, 1, {}, 1);
  control.force(500);
  control.restart();
  EXPECT_EQ(run(control, 1, {}, 1), 1);
}

// The nodes of a section, `exponent` being how fast they fall with the tolerance; measured up to `most`.
struct Sections {
  double at_1_px, exponent, most;
  int calls = 0;

  double nodes(double tau_px) const { return at_1_px * std::pow(tau_px, -exponent); }
  double load(double tau_px) {
    ++calls;
    const double share = nodes(tau_px) / most;
    return share <= 1 ? share : std::numeric_limits<double>::infinity();
  }
};

TEST(ToleranceThatFits, IsTheWantedOneIfThatFits) {
  Sections sections{1000, 1.2, 2000};
  EXPECT_EQ(toleranceThatFits(1, 0, [&](double tau_px) { return sections.load(tau_px); }), 1);
  EXPECT_EQ(sections.calls, 1);
}

TEST(ToleranceThatFits, FindsOneThatFitsAndIsHardlyCoarserThanNeeded) {
  for (const double exponent : {0.6, 1.2, 2.0})
    for (const double most : {30.0, 500.0, 40'000.0})
      for (const double guess_px : {0.0, 2.0, 3000.0}) {
        Sections sections{1e6, exponent, most};
        const double tau_px = toleranceThatFits(0.25, guess_px, [&](double tau) { return sections.load(tau); });
        SCOPED_TRACE(testing::Message() << exponent << ", " << most << ", " << guess_px << ": " << tau_px);
        EXPECT_LE(sections.nodes(tau_px), most);
        EXPECT_TRUE(sections.nodes(tau_px) >= kMinLoad * most || sections.nodes(tau_px / 1.11) > most);
        EXPECT_LE(sections.calls, kMaxTries);
      }
}

TEST(ToleranceThatFits, AGuessThatFitsEndsTheSearch) {
  Sections sections{1e6, 1.2, 10'000};
  const double guess_px = toleranceThatFits(1, 0, [&](double tau_px) { return sections.load(tau_px); });
  sections.calls = 0;
  EXPECT_EQ(toleranceThatFits(1, guess_px, [&](double tau_px) { return sections.load(tau_px); }), guess_px);
  EXPECT_EQ(sections.calls, 2);
}

TEST(ToleranceThatFits, EndsThoughNothingFits) {
  int calls = 0;
  const auto never = [&](double) { return ++calls, std::numeric_limits<double>::infinity(); };
  EXPECT_EQ(toleranceThatFits(0.01, 0, never), kMaxTolerance_px);
  EXPECT_LE(calls, kMaxTries);
}

}  // namespace
}  // namespace foreland::server
