#include "client/shown_frame.h"

#include <gtest/gtest.h>

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

}  // namespace
}  // namespace foreland::client
