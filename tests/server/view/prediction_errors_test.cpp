#include "server/view/prediction_errors.h"

#include <gtest/gtest.h>

#include <cmath>

namespace foreland::server {
namespace {

const proto::Pose kTruth{{0, 0, 0}, {1, 0, 0, 0}};
constexpr Duration kInterval = Duration::milliseconds(200);

proto::Pose off(double metres, double rad) { return {{metres, 0, 0}, {std::cos(rad / 2), std::sin(rad / 2), 0, 0}}; }

TEST(PredictionErrors, EstimatesNothingBeforeTheFirst) {
  EXPECT_EQ(PredictionErrors().estimate(kInterval).radius_m, 0);
  EXPECT_EQ(PredictionErrors().estimate(kInterval).angle_rad, 0);
}

TEST(PredictionErrors, CoversTheLargestOfEitherKindWithSafety) {
  PredictionErrors errors;
  errors.add(off(4, 0.01), kTruth, kInterval);
  errors.add(off(1, 0.2), kTruth, kInterval);
  EXPECT_NEAR(errors.estimate(kInterval).radius_m, 6, 1e-12);
  EXPECT_NEAR(errors.estimate(kInterval).angle_rad, 0.3, 1e-9);
}

TEST(PredictionErrors, ForgetsAllButTheLastTen) {
  PredictionErrors errors;
  errors.add(off(100, 1), kTruth, kInterval);
  for (size_t i = 1; i < PredictionErrors::kMemory; ++i) errors.add(off(2, 0), kTruth, kInterval);
  EXPECT_NEAR(errors.estimate(kInterval).radius_m, 150, 1e-9);
  errors.add(off(2, 0), kTruth, kInterval);
  EXPECT_NEAR(errors.estimate(kInterval).radius_m, 3, 1e-9);
  EXPECT_LT(errors.estimate(kInterval).angle_rad, 1e-9);
}

TEST(PredictionErrors, OfOtherIntervalsCountInProportion) {
  PredictionErrors errors;
  errors.add(off(4, 0.02), kTruth, kInterval * 2);
  EXPECT_NEAR(errors.estimate(kInterval * 2).radius_m, 6, 1e-12);
  EXPECT_NEAR(errors.estimate(kInterval).radius_m, 3, 1e-12);
  EXPECT_NEAR(errors.estimate(kInterval * 4).angle_rad, 0.06, 1e-9);
}

}  // namespace
}  // namespace foreland::server
