#include "client/fly/exaggeration.h"

#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>

#include "base/rng.h"
#include "tests/support/seed.h"

namespace foreland::client {
namespace {

// Where a camera draws what lies in a direction, in pixels, if heights are so many times as tall.
glm::dvec2 project(const proto::Pose& pose, const proto::Lens& lens, double factor, const glm::dvec3& direction) {
  const glm::dvec3 tall(direction.x, direction.y, factor * direction.z);
  return glm::dvec2(glm::dot(pose.right(), tall), glm::dot(pose.up(), tall)) *
         (lens.focalPx() / glm::dot(pose.forward(), tall));
}

struct View {
  Exaggeration heights;
  proto::Pose drawn;
};

View randomView(Rng& rng) {
  const proto::Lens lens{.vertical_fov_rad = rng.uniform(0.5, 1.3),
                         .width_px = static_cast<uint32_t>(rng.uniform(400, 1600)),
                         .height_px = static_cast<uint32_t>(rng.uniform(400, 1000))};
  const double yaw = rng.uniform(0, 6.28), pitch = rng.uniform(-1.5, 1.5);
  const glm::dvec3 ahead(std::cos(yaw) * std::cos(pitch), std::sin(yaw) * std::cos(pitch), std::sin(pitch));
  return {Exaggeration::of(rng.uniform(Exaggeration::kLeast, 3), lens),
          {.eye = {1, 2, 3}, .orientation = proto::lookAlong(ahead, {0, 0, 1})}};
}

// A direction in the middle of the scene that the drawn picture shows at this place of it (-1 to 1).
glm::dvec3 shownAt(const View& view, const glm::dvec2& side) {
  const proto::Lens& lens = view.heights.drawn;
  const double tan_tall = lens.tanHalfFov(), tan_wide = tan_tall * lens.width_px / lens.height_px;
  const glm::dvec3 drawn = view.drawn.orientation * glm::dvec3(side.x * tan_wide, side.y * tan_tall, -1);
  return {drawn.x, drawn.y, drawn.z / view.heights.factor};
}

TEST(Exaggeration, AsksForAllThatIsDrawn) {
  Rng rng(test::randomSeed());
  for (int i = 0; i < 100; ++i) {
    const View view = randomView(rng);
    ASSERT_TRUE(isUsable(view.heights.asked));
    const proto::Pose asked = view.heights.askedPose(view.drawn);
    for (int k = 0; k < 50; ++k) {
      const glm::dvec3 seen = shownAt(view, {rng.uniform(-1, 1), rng.uniform(-1, 1)});
      ASSERT_GT(glm::dot(asked.forward(), seen), 0);
      const glm::dvec2 at = project(asked, view.heights.asked, 1, seen);
      EXPECT_LE(std::fabs(at.x), 0.5 * view.heights.asked.width_px + 1e-9) << "factor " << view.heights.factor;
      EXPECT_LE(std::fabs(at.y), 0.5 * view.heights.asked.height_px + 1e-9) << "factor " << view.heights.factor;
    }
  }
}

TEST(Exaggeration, OfAPixelThatIsAskedForIsAtMostSoManyThatAreDrawn) {
  Rng rng(test::randomSeed());
  double closest = 0;
  for (int i = 0; i < 100; ++i) {
    const View view = randomView(rng);
    const proto::Pose asked = view.heights.askedPose(view.drawn);
    for (int k = 0; k < 50; ++k) {
      const glm::dvec3 seen = shownAt(view, {rng.uniform(-1, 1), rng.uniform(-1, 1)});
      const glm::dvec3 moved = seen + 1e-6 * glm::dvec3(rng.uniform(-1, 1), rng.uniform(-1, 1), rng.uniform(-1, 1));
      const auto steps = [&](const proto::Pose& pose, const proto::Lens& lens, double factor) {
        return glm::distance(project(pose, lens, factor, seen), project(pose, lens, factor, moved));
      };
      const double drawn_px = steps(view.drawn, view.heights.drawn, view.heights.factor),
                   asked_px = steps(asked, view.heights.asked, 1);
      EXPECT_LE(drawn_px, asked_px * view.heights.finer * (1 + 1e-4)) << "factor " << view.heights.factor;
      closest = std::max(closest, drawn_px / (asked_px * view.heights.finer));
    }
  }
  EXPECT_GT(closest, 0.8) << "a bound that is never approached is not tested";
}

TEST(Exaggeration, FindsTheCameraThatIsDrawnAgain) {
  Rng rng(test::randomSeed());
  for (int i = 0; i < 100; ++i) {
    const View view = randomView(rng);
    const proto::Pose again = view.heights.drawnPose(view.heights.askedPose(view.drawn));
    EXPECT_LT(proto::angleBetween(again.orientation, view.drawn.orientation), 1e-7);
    EXPECT_EQ(again.eye, view.drawn.eye);
  }
}

TEST(Exaggeration, ChangesNothingWhereHeightsAreTrue) {
  const proto::Lens lens{.width_px = 640, .height_px = 360};
  const Exaggeration heights = Exaggeration::of(1, lens);
  const proto::Pose rolled{.eye = {1, 2, 3}, .orientation = glm::normalize(glm::dquat(1, 2, 3, 4))};
  EXPECT_EQ(heights.asked, lens);
  EXPECT_EQ(heights.finer, 1);
  EXPECT_EQ(heights.askedPose(rolled).orientation, rolled.orientation);
  EXPECT_EQ(heights.drawnPose(rolled).orientation, rolled.orientation);
}

TEST(Exaggeration, AsksForNoLargerLensThanThereMayBe) {
  const proto::Lens large{.vertical_fov_rad = 1.5, .width_px = 8000, .height_px = 4000};
  const Exaggeration heights = Exaggeration::of(5, large);
  EXPECT_TRUE(isUsable(heights.asked));
  EXPECT_GT(heights.finer, large.focalPx() / heights.asked.focalPx());
}

}  // namespace
}  // namespace foreland::client
