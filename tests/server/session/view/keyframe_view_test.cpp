// For which time and region a keyframe is computed. What is shown between two keyframes must lie in the regions of
// both, whatever the order of the blend and the intervals.
#include "server/session/view/keyframe_view.h"

#include <gtest/gtest.h>

#include <rapidcheck.h>
#include <glm/geometric.hpp>

namespace foreland::server {
namespace {

// What a viewer shows until a keyframe of time `t` has come: with the blend of order n it ends (n + 1) / 2 intervals
// before that, counted from the middle of what it blends.
TEST(ShownFrom, JoinsToTheKeyframeBefore) {
  EXPECT_TRUE(rc::check([] {
    KeyframeState state;
    state.grid = Duration::milliseconds(*rc::gen::inRange<int64_t>(20, 500));
    state.order = *rc::gen::inRange<uint32_t>(1, 4);
    state.newest_client = Time::seconds(50);
    state.last_client = Time::seconds(49);
    state.last_step = state.interval = state.grid * *rc::gen::inRange<int64_t>(1, 4);
    const Time t = *state.last_client + state.interval;
    // Keyframes that come evenly: it is shown for as long before its time as the blend reaches.
    RC_ASSERT(shownFrom(state, t) <= t - state.leadTime(state.last_step));
    RC_ASSERT(shownUntil(state, t, state.interval) == t + state.leadTime(state.interval));
    // Of order 1, from the keyframe before it to the one after it.
    if (state.order == 1) RC_ASSERT(shownFrom(state, t) == *state.last_client);
  }));
}

TEST(ShownFrom, IsAtOnceForTheFirstAndAfterAJump) {
  KeyframeState state;
  state.grid = state.interval = state.last_step = Duration::milliseconds(200);
  state.newest_client = Time::seconds(10);
  EXPECT_LE(shownFrom(state, Time::seconds(10.4)), state.newest_client);
  state.last_client = Time::seconds(5);
  state.has_jumped = true;
  EXPECT_EQ(shownFrom(state, Time::seconds(10.4)), state.newest_client);
}

// An eye that goes straight on at 30 m/s stays in the region for as long as the keyframe is shown.
TEST(RegionOfAKeyframe, HoldsTheMotionForAsLongAsItIsShown) {
  ViewerMotion motion;
  for (int i = 0; i < 20; ++i)
    motion.add({Time::seconds(8) + Duration::milliseconds(50 * i), {{1.5 * i, 0, 100}, glm::dquat(1, 0, 0, 0)}});
  proto::ViewRequest request;
  request.strategy = proto::Strategy::kPredict;
  for (const uint32_t order : {1u, 2u, 3u})
    for (const Duration until_next : {Duration::milliseconds(200), Duration::milliseconds(1000)}) {
      request.order = order;
      KeyframeState state;
      state.grid = state.interval = state.last_step = Duration::milliseconds(200);
      state.order = order;
      state.newest_client = motion.newest().time;
      state.last_client = Time::seconds(8.8);
      const Time t = Time::seconds(9.4);
      const RegionParts parts = regionFor(state, motion, request, t, until_next);
      const ExpectedMotion expected = motion.expected(request);
      const proto::View view = viewFor(motion, request, 2, t, parts);
      EXPECT_EQ(view.tau_px, 2);
      const double held_m = parts.motion.radius_m + parts.error.radius_m + parts.rest.radius_m;
      EXPECT_NEAR(view.region_radius_m, held_m, 1e-3 * held_m);
      for (Time at = shownFrom(state, t); at <= shownUntil(state, t, until_next); at = at + Duration::milliseconds(10))
        EXPECT_LE(glm::distance(expected.at(at).eye, view.pose.eye), held_m + 1e-6) << order << ' ' << at.us;
      EXPECT_GE(asDecoded(view, 2).region_radius_m, view.region_radius_m);
    }
}

// It is as much wider as eyes are from the camera, whatever is left of what predictions may be off by.
TEST(RegionOfAKeyframe, HoldsTheEyesAboutTheCamera) {
  ViewerMotion motion;
  for (int i = 0; i < 20; ++i)
    motion.add({Time::seconds(8) + Duration::milliseconds(50 * i), {{1.5 * i, 0, 100}, glm::dquat(1, 0, 0, 0)}});
  KeyframeState state;
  state.grid = state.interval = state.last_step = Duration::milliseconds(200);
  state.newest_client = motion.newest().time;
  state.last_client = Time::seconds(8.8);
  const auto regionOf = [&](double eye_radius_m) {
    proto::ViewRequest request;
    request.eye_radius_m = eye_radius_m;
    return regionFor(state, motion, request, Time::seconds(9.4), state.grid);
  };
  const RegionParts alone = regionOf(0), head = regionOf(0.032);
  EXPECT_DOUBLE_EQ(head.withoutErrors().radius_m, alone.withoutErrors().radius_m + 0.032);
  EXPECT_EQ(head.error.radius_m, alone.error.radius_m);
  EXPECT_EQ(head.withoutErrors().angle_rad, alone.withoutErrors().angle_rad);
}

}  // namespace
}  // namespace foreland::server
