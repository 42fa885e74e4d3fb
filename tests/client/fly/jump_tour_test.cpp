// Jumps over a globe lead anywhere, and every view stands above the ground with the sky up.
#include "client/fly/jump_tour.h"

#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>

namespace foreland::client {
namespace {

TEST(JumpTour, GoesToTheOtherSideOfAGlobe) {
  proto::Frame frame;
  frame.kind = proto::FrameKind::kGlobe;
  frame.face_steps = 1u << 17;
  const proto::FrameTransform transform(frame);
  auto tour = JumpTour::plan(transform, proto::GridTopology::cubeShape(17), 60);
  ASSERT_TRUE(tour.ok());
  ASSERT_EQ(tour->views(), 15u);
  std::vector<float> ground(tour->positions().size());
  for (size_t i = 0; i < ground.size(); ++i) ground[i] = static_cast<float>(100 * (i % 7));
  tour->setGround(ground);
  double farthest = 0;
  for (size_t view = 0; view < tour->views(); ++view) {
    const Duration begin = JumpTour::kEvery * static_cast<int64_t>(view);
    for (const Duration after : {Duration{}, JumpTour::kEvery - Duration{1}}) {
      const proto::Pose pose = tour->at(begin + after);
      const glm::dvec3 up = transform.upAt(pose.eye);
      const double height_m = transform.toGeodetic(pose.eye).height_m;
      EXPECT_GE(height_m, JumpTour::kAboveGround_m - 0.1) << view;
      EXPECT_LE(height_m, JumpTour::kAboveGround_m + 600.1) << view;
      EXPECT_NEAR(glm::dot(pose.forward(), up), std::sin(-0.2), 1e-3) << view;
      EXPECT_NEAR(glm::dot(pose.right(), up), 0, 1e-3) << view;
    }
    if (view > 0) farthest = std::max(farthest, glm::distance(tour->at(begin).eye, tour->at(begin - Duration{1}).eye));
  }
  EXPECT_GT(farthest, 1.9 * frame.semi_major_m);
}

}  // namespace
}  // namespace foreland::client
