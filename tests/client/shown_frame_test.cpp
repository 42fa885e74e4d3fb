#include "client/shown_frame.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace foreland::client {
namespace {

proto::Pose at(double x) { return {{x, 0, 100}, {1, 0, 0, 0}}; }

// A small step that is told to be a jump; the camera was nowhere between its two sides.
TEST(CameraPath, WasNowhereBetweenTheSidesOfAJumpThatItWasTold) {
  for (const bool is_told : {true, false}) {
    CameraPath camera;
    camera.add(Time::seconds(1), at(0));
    camera.add(Time::seconds(1.1), at(1));
    EXPECT_FALSE(camera.hasJustJumped());
    if (is_told) camera.jump();
    camera.add(Time::seconds(1.1), at(2));  // no new time, so not yet
    EXPECT_FALSE(camera.hasJustJumped());
    camera.add(Time::seconds(1.2), at(3));
    EXPECT_EQ(camera.hasJustJumped(), is_told);
    EXPECT_NEAR(camera.at(Time::seconds(1.15)).eye.x, is_told ? 1 : 2, 1e-9);
    EXPECT_EQ(camera.at(Time::seconds(1.2)).eye.x, 3);
    camera.add(Time::seconds(1.3), at(4));
    EXPECT_FALSE(camera.hasJustJumped());
    EXPECT_EQ(camera.hasJumpedSince(Time::seconds(1.15)), is_told);
    EXPECT_FALSE(camera.hasJumpedSince(Time::seconds(1.2)));
    EXPECT_NEAR(camera.at(Time::seconds(1.25)).eye.x, 3.5, 0.3);
  }
}

TEST(CameraPath, ForgetsJumpsWithThePosesAboutThem) {
  CameraPath camera;
  for (int i = 0; i < 3000; ++i) {
    camera.jump();
    camera.add(Time{20'000 * i}, at(i));
    EXPECT_TRUE(i == 0 || camera.hasJustJumped());
  }
  EXPECT_TRUE(camera.hasJumpedSince(Time{20'000 * 2998}));
  EXPECT_FALSE(camera.hasJumpedSince(Time{20'000 * 2999}));
}

// Each eye has to be in the regions of both keyframes.
TEST(ShownFrame, GuaranteesWhatTheSectionsDoForAllEyesAboutTheCamera) {
  const proto::Lens lens{1, 640, 480};
  Interval interval;
  interval.from.pose = at(0);
  interval.to.pose = at(4);
  for (proto::KeyframeHeader* header : {&interval.from, &interval.to}) {
    header->lens = lens;
    header->tau_px = 1;
    header->region_radius_m = 5;
    header->region_angle_rad = 0.1F;
  }
  Schedule::Shown shown;
  shown.interval = &interval;
  shown.weight = 0.5;
  const auto isGuaranteed = [&](double x, double eye_radius_m) {
    const ShownFrame frame = showFrame(shown, {}, {at(x), lens, eye_radius_m}, proto::Strategy::kPredict);
    EXPECT_EQ(frame.is_outside, std::isinf(frame.tolerance_px));
    return !frame.is_outside;
  };
  for (const double x : {-0.9, 0.0, 1.5, 2.0, 3.7, 4.9}) {
    const double room_m = 5 - std::max(std::abs(x), std::abs(x - 4));
    EXPECT_TRUE(isGuaranteed(x, 0)) << x;
    EXPECT_TRUE(isGuaranteed(x, room_m - 1e-3)) << x;
    EXPECT_FALSE(isGuaranteed(x, room_m + 1e-3)) << x;
  }
}

}  // namespace
}  // namespace foreland::client
