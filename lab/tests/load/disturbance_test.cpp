// What disturbs a load, and how its variability shows.
#include <gtest/gtest.h>

#include "lab/load/load_run.h"
#include "tests/support/scene.h"

namespace foreland::lab {
namespace {

// Every keyframe costs 4 ms; twenty viewers use two fifths of the worker.
LoadOptions calmLoad() {
  LoadOptions options;
  options.viewers = 20;
  options.seconds = 4;
  options.tau_px = 20;
  options.mix = Mix::kSurvey;
  options.phases = Phases::kStaggered;
  options.start = LoadStart::kEarly;
  options.prices = {"test", 4e6, 0, 0, 0, 0, 0, 0};
  return options;
}

LoadFigures figuresOf(const LoadOptions& options) {
  static const auto world = std::make_shared<server::World>(test::makeScene(129, 129, 5));
  return runLoad(world, options).figures;
}

TEST(Disturbance, ACalmLoadHasNoPeaks) {
  const LoadFigures f = figuresOf(calmLoad());
  EXPECT_GE(f.peak_over_mean, 1);
  EXPECT_LT(f.peak_over_mean, 1.3);
  EXPECT_EQ(f.over_budget_share, 0);
  EXPECT_EQ(f.at_once, 0u);
}

// Work by 60 ms where 20 ms are asked for each keyframe interval: too much, in every one.
TEST(Disturbance, WorkBeyondTheBudgetIsCounted) {
  LoadOptions options = calmLoad();
  options.viewers = 1;
  options.keyframe_ms = 20;
  options.prices.keyframe = 60e6;
  const LoadFigures f = figuresOf(options);
  // Each keyframe that is done is more than its interval holds; those that are skipped leave theirs empty.
  EXPECT_GT(f.over_budget_share, 0.2);
  EXPECT_LT(f.over_budget_share, 0.5);
  EXPECT_GT(f.peak_over_mean, 2);
}

TEST(Disturbance, ANeighbourMakesWorkLongWhileItIsThere) {
  LoadOptions options = calmLoad();
  const LoadFigures calm = figuresOf(options);
  options.neighbour = 0.8;
  const LoadFigures beside = figuresOf(options);
  EXPECT_EQ(calm.missed, 0u);
  EXPECT_GT(beside.missed, 10u);
  EXPECT_GT(beside.peak_over_mean, 1.3 * calm.peak_over_mean);
  EXPECT_GT(beside.over_budget_share, 0);
  EXPECT_LE(beside.over_budget_share, 0.4);  // it is there in a quarter of the time
  EXPECT_GT(beside.utilisation, calm.utilisation);
  EXPECT_LE(beside.utilisation_peak, 1 + 1e-9);
}

TEST(Disturbance, ACrowdJumpsTogether) {
  LoadOptions options = calmLoad();
  const LoadFigures calm = figuresOf(options);
  options.crowd_jump_s = 2;
  const LoadFigures crowd = figuresOf(options);
  EXPECT_GE(crowd.at_once, 20u);  // at 4 and 6 s, of 3 to 7
  EXPECT_GT(crowd.at_once_p99_ms, 4);
  EXPECT_GT(crowd.peak_over_mean, calm.peak_over_mean);
}

}  // namespace
}  // namespace foreland::lab
