#include "client/area.h"

#include <gtest/gtest.h>

#include <limits>
#include <set>

#include "base/rng.h"
#include "client/viewer.h"
#include "proto/message/message.h"

namespace foreland::client {
namespace {

constexpr uint32_t kAreaSide = 1u << kAreaLog2;

proto::GridShape shapeOf(uint32_t samples_x, uint32_t samples_y) {
  return proto::GridTopology::shapeFor(samples_x, samples_y);
}

TEST(Area, IsTheSameForAllOfASquareAndNoOther) {
  const uint64_t seed = 26;
  Rng random(seed);
  for (int i = 0; i < 1000; ++i) {
    const uint32_t columns = 2 + static_cast<uint32_t>(random.below(20)),
                   rows = 1 + static_cast<uint32_t>(random.below(20));
    const uint32_t x = static_cast<uint32_t>(random.below(columns)), y = static_cast<uint32_t>(random.below(rows));
    const proto::GridShape shape = shapeOf(columns * kAreaSide + 1, rows * kAreaSide + 1);
    const glm::dvec2 within(random.uniform(), random.uniform());
    EXPECT_EQ(areaOf(shape, (glm::dvec2(x, y) + within) * double(kAreaSide)), y * columns + x)
        << "seed " << seed << ", " << i;
  }
}

TEST(Area, IsNotToldOfScenesThatAreOne) {
  for (const uint32_t samples : {2u, 3u, 1201u, kAreaSide, kAreaSide + 1}) {
    EXPECT_EQ(areaOf(shapeOf(samples, samples), {1, 1}), std::nullopt) << samples;
    EXPECT_EQ(areaOf(shapeOf(samples, 2), {1, 1}), std::nullopt) << samples;
  }
  EXPECT_EQ(areaOf(shapeOf(kAreaSide + 2, 2), {1, 1}), 0u);
  EXPECT_EQ(areaOf(shapeOf(2, kAreaSide + 2), {1, kAreaSide + 1}), 1u);
  EXPECT_EQ(areaOf(proto::GridTopology::cubeShape(kAreaLog2 - 3), {1, 1}), std::nullopt) << "six faces in one area";
}

// Every face has areas of its own, all are counted, and none twice.
TEST(Area, CountsThoseOfAllFacesOfAGlobe) {
  const proto::GridShape globe = proto::GridTopology::cubeShape(kAreaLog2 + 1);
  const double face = 2.0 * kAreaSide;
  std::set<uint32_t> seen;
  for (uint32_t f = 0; f < 6; ++f)
    for (const glm::dvec2 within : {glm::dvec2(0.2, 0.2), {0.7, 0.2}, {0.2, 0.7}, {0.7, 0.7}}) {
      const auto area = areaOf(globe, glm::dvec2(f + within.x, within.y) * face);
      ASSERT_TRUE(area);
      EXPECT_EQ(*area % 12 / 2, f);
      EXPECT_TRUE(seen.insert(*area).second) << *area;
    }
  EXPECT_EQ(seen.size(), 24u);
  EXPECT_EQ(*seen.rbegin(), 23u);
}

TEST(Area, OfPlacesOutsideIsTheNearest) {
  const proto::GridShape shape = shapeOf(3 * kAreaSide + 1, 2 * kAreaSide + 1);
  const double far = std::numeric_limits<double>::max();
  EXPECT_EQ(areaOf(shape, {-far, -far}), 0u);
  EXPECT_EQ(areaOf(shape, {far, -1e-300}), 2u);
  EXPECT_EQ(areaOf(shape, {-1, far}), 3u);
  EXPECT_EQ(areaOf(shape, {far, far}), 5u);
  EXPECT_EQ(areaOf(shape, {3.0 * kAreaSide, 2.0 * kAreaSide}), 5u) << "the last sample";
  const double nan = std::numeric_limits<double>::quiet_NaN(), infinity = std::numeric_limits<double>::infinity();
  for (const double bad : {nan, infinity, -infinity}) {
    EXPECT_EQ(areaOf(shape, {bad, 1}), std::nullopt);
    EXPECT_EQ(areaOf(shape, {1, bad}), std::nullopt);
    EXPECT_EQ(areaOf(shape, {bad, -bad}), std::nullopt);
  }
}

// Nine digits are what deploy/haproxy-fleet.cfg takes.
TEST(Area, HasNineDigitsAtMost) {
  for (const proto::GridShape& shape : {proto::GridTopology::cubeShape(proto::GridTopology::kMaxCubeLog2),
                                        shapeOf(proto::GridTopology::kMaxSamples, 1u << 17)}) {
    const auto last = areaOf(shape, {shape.samples_x, shape.samples_y});
    ASSERT_TRUE(last);
    EXPECT_LT(*last, 1u << 29);
    EXPECT_LT(*last, 1'000'000'000u);
  }
}

TEST(Area, OfAViewerIsThatOfItsCameraInItsScene) {
  Viewer viewer({});
  EXPECT_EQ(viewer.area(), std::nullopt);
  proto::Welcome welcome;
  welcome.shape = shapeOf(3 * kAreaSide + 1, 3 * kAreaSide + 1);
  welcome.frame.anchor = {kAreaSide * 1.5, kAreaSide * 1.5};
  welcome.keyframe_interval = Duration::milliseconds(200);
  welcome.frame.axis_x_m = {10, 0};
  welcome.frame.axis_y_m = {0, 10};
  welcome.corner_heights.assign((welcome.shape.roots_x + 1) * (welcome.shape.roots_y + 1), 0);
  welcome.centre_heights.assign(welcome.shape.roots_x * welcome.shape.roots_y, 0);
  const auto message = proto::encode(welcome);
  const Status received = viewer.receive(message, {});
  ASSERT_TRUE(received.ok()) << received.error().message;
  EXPECT_EQ(viewer.area(), std::nullopt) << "it has not drawn";
  viewer.frame({1}, {.eye = {0, 0, 1000}});
  EXPECT_EQ(viewer.area(), 4u);
  viewer.frame({2}, {.eye = {10.0 * kAreaSide, 0, 1000}});
  EXPECT_EQ(viewer.area(), 5u);
  viewer.reconnect({3});
  EXPECT_EQ(viewer.area(), 5u) << "between two connections";
}

}  // namespace
}  // namespace foreland::client
