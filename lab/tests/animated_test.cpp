#include <gtest/gtest.h>

#include "lab/animated/flights.h"
#include "lab/animated/orders.h"
#include "server/view/tour.h"
#include "tests/support/scene.h"
#include "tests/support/seed.h"

namespace foreland::lab {
namespace {

constexpr double kDay = 86'400;

FlightOptions smallFlight() {
  return {.lens = {1.0, 320, 240}, .tau_px = 2, .keyframe_interval = Duration::milliseconds(200), .seconds = 6};
}

// Both bases are the linear blend at order 1, whose velocity jumps; splines of higher order have none.
TEST(Animated, HigherOrdersHaveNoJumpsOfVelocity) {
  const uint64_t seed = test::randomSeed();
  SCOPED_TRACE(seed);
  for (const bool moves : {false, true}) {
    const auto scene = moves ? test::makeMovingScene(120, 100, seed, 4) : test::makeScene(120, 100, seed);
    const server::Hierarchy hierarchy(scene);
    const FlightOptions options = smallFlight();
    const auto path = server::planTour(*scene, "orbit", 30).value();
    const auto views = keyframeViews(path, options, Guarantee::kEveryFrame);
    std::vector<Time> scene_times;
    const proto::Epochs& epochs = hierarchy.epochs().epochs();
    for (size_t k = 0; moves && k < views.size(); ++k)
      scene_times.push_back(proto::SceneClock{Time{}, epochs.first(), 60 * kDay}.timeAt(
          epochs, Time{} + options.keyframe_interval * static_cast<int64_t>(k)));
    const auto figures = measureOrders(hierarchy, views, scene_times, options.keyframe_interval);
    ASSERT_EQ(figures.size(), 6u);
    for (const OrderFigures& f : figures) {
      SCOPED_TRACE(f.order);
      EXPECT_GT(f.vertices, 1000u);
      EXPECT_EQ(f.joints, views.size() - 6);
      const bool is_smooth = f.basis == oracle::Basis::kBSpline && f.order > 1;
      if (is_smooth)
        EXPECT_LE(f.velocity_jump_max_px_s, 0.001 * figures[0].velocity_jump_max_px_s);
      else
        EXPECT_GT(f.velocity_jump_max_px_s, 0.1);
      EXPECT_GE(f.lead_ms, 200);
    }
    EXPECT_EQ(figures[0].velocity_jump_max_px_s, figures[3].velocity_jump_max_px_s);
  }
}

TEST(Animated, FlightsKeepTheToleranceAndPayForMotion) {
  const uint64_t seed = test::randomSeed();
  SCOPED_TRACE(seed);
  const auto scene = test::makeMovingScene(150, 130, seed, 5);
  const auto world = std::make_shared<server::World>(scene);
  const auto path = server::planTour(*scene, "orbit", 30).value();
  const auto running = flyAnimated(world, scene, path, smallFlight(), 80 * kDay, 3).value();
  const auto stopped = flyAnimated(world, scene, path, smallFlight(), 0, 3).value();
  for (const AnimatedFlight& flown : {running, stopped}) {
    EXPECT_GT(flown.frames_judged, 100u);
    EXPECT_EQ(flown.frames_over_tau, 0u);
    EXPECT_GT(flown.max_error_px_frames, 0.2);
    EXPECT_GT(flown.keyframes, 25u);
    EXPECT_EQ(flown.late_keyframes, 0u);
  }
  EXPECT_GT(running.bytes_down, stopped.bytes_down);
}

}  // namespace
}  // namespace foreland::lab
