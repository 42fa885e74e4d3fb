#include "server/view/prediction_errors.h"

#include <gtest/gtest.h>

#include <cmath>

namespace foreland::server {
namespace {

const proto::Pose kTruth{{0, 0, 0}, {1, 0, 0, 0}};

proto::Pose off(double metres, double rad) { return {{metres, 0, 0}, {std::cos(rad / 2), std::sin(rad / 2), 0, 0}}; }

TEST(PredictionErrors, EstimatesNothingBeforeTheFirst) {
  EXPECT_EQ(PredictionErrors().estimate().radius_m, 0);
  EXPECT_EQ(PredictionErrors().estimate().angle_rad, 0);
}

TEST(PredictionErrors, CoversTheLargestOfEitherKindWithSafety) {
  PredictionErrors errors;
  errors.add(off(4, 0.01), kTruth);
  errors.add(off(1, 0.2), kTruth);
  EXPECT_NEAR(errors.estimate().radius_m, 6, 1e-12);
  EXPECT_NEAR(errors.estimate().angle_rad, 0.3, 1e-9);
}

TEST(PredictionErrors, ForgetsAllButTheLastTen) {
  PredictionErrors errors;
  errors.add(off(100, 1), kTruth);
  for (size_t i = 1; i < PredictionErrors::kMemory; ++i) errors.add(off(2, 0), kTruth);
  EXPECT_NEAR(errors.estimate().radius_m, 150, 1e-9);
  errors.add(off(2, 0), kTruth);
  EXPECT_NEAR(errors.estimate().radius_m, 3, 1e-9);
  EXPECT_LT(errors.estimate().angle_rad, 1e-9);
}

}  // namespace
}  // namespace foreland::server
