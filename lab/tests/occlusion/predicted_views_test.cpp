#include "lab/occlusion/predicted_views.h"

#include <gtest/gtest.h>

#include <glm/geometric.hpp>

#include "lab/tests/occlusion/ridge.h"

namespace foreland::lab {
namespace {

class PredictedViews : public testing::Test {
 protected:
  server::Hierarchy hierarchy_{test::ridgeScene()};
  FlightOptions options_ = test::ridgeOptions(4);
  proto::Path path_ = test::ridgeFlight(hierarchy_, 4);
};

TEST_F(PredictedViews, KnowThePath) {
  const auto known = predictedFlight(path_, options_, proto::Predictor::kKnownPath).views;
  const auto expected = keyframeViews(path_, options_, Guarantee::kEveryFrame);
  ASSERT_EQ(known.size(), expected.size());
  for (size_t i = 0; i < known.size(); ++i) {
    EXPECT_EQ(known[i].pose.eye, expected[i].pose.eye);
    EXPECT_EQ(known[i].region_radius_m, expected[i].region_radius_m);
  }
}

// At 20 m/s, and a quarter of a second late.
TEST_F(PredictedViews, LagBehindWithoutVelocity) {
  const auto still = predictedFlight(path_, options_, proto::Predictor::kHold).views;
  const auto moving = predictedFlight(path_, options_, proto::Predictor::kConstantVelocity).views;
  ASSERT_EQ(still.size(), 21u);
  ASSERT_EQ(moving.size(), 21u);
  for (size_t i = 5; i < still.size(); ++i) {
    const glm::dvec3 eye = path_.at(Time{} + options_.keyframe_interval * static_cast<int64_t>(i)).eye;
    EXPECT_NEAR(glm::distance(moving[i].pose.eye, eye), 0, 1e-6) << i;
    EXPECT_NEAR(glm::distance(still[i].pose.eye, eye), 5, 1e-6) << i;
    EXPECT_GT(still[i].region_radius_m, 5) << i;
  }
}

}  // namespace
}  // namespace foreland::lab
