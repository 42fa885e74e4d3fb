#include "lab/martini/uniform.h"

#include "proto/refine/refine.h"
#include "tests/support/scene.h"

namespace foreland::lab {
namespace {

proto::Section refined(const server::Hierarchy& hierarchy, const proto::View& view) {
  proto::RefineScratch scratch;
  proto::Section section;
  CHECK_TRUE(server::refine(hierarchy, view, size_t{1} << 30, scratch, section));
  return section;
}

TEST(UniformView, KeepsTheErrorEverywhere) {
  for (const auto& [width, height] : {std::pair{129u, 129u}, {200u, 75u}, {33u, 140u}}) {
    const server::Hierarchy hierarchy(test::makeScene(width, height, 7), proto::ErrorBound::kSphere);
    size_t last = 0;
    for (double max_error_m : {50.0, 20.0, 5.0, 1.0}) {
      const proto::Section section = refined(hierarchy, uniformView(hierarchy, max_error_m));
      EXPECT_LE(trueError_m(hierarchy.scene(), section).value(), 1.01 * max_error_m) << width << " x " << height;
      EXPECT_GT(section.slots.size(), last);
      last = section.slots.size();
    }
  }
}

TEST(UniformView, WantsNothingAboveTheRootsError) {
  const server::Hierarchy hierarchy(test::makeScene(65, 65, 7), proto::ErrorBound::kSphere);
  EXPECT_TRUE(refined(hierarchy, uniformView(hierarchy, 1e5)).slots.empty());
}

TEST(TrueError, IsTheDisplacementOfTheOnlyNodeLeftOut) {
  const auto spike = [](uint32_t x, uint32_t y) { return x == 5 && y == 4 ? 40.0 : 0.0; };
  const auto scene = test::makeScene(17, 17, spike);
  EXPECT_DOUBLE_EQ(trueError_m(*scene, {}).value(), 40.0);
  proto::Section all;
  for (proto::Slot slot = 0; slot < scene->grid().slotCount(); ++slot)
    if (!scene->grid().isBase(scene->grid().node(slot))) all.slots.push_back(slot);
  EXPECT_EQ(trueError_m(*scene, all).value(), 0.0);
}

TEST(NearestError, GrowsWithTheToleranceAndTheHeight) {
  const auto scene = test::makeScene(129, 129, [](uint32_t x, uint32_t y) { return (x + y) % 2 ? 8.0 : 0.0; });
  const server::Hierarchy hierarchy(scene);
  proto::View view;
  view.pose.eye = {0, 0, 1008};
  view.tau_px = 1;
  const double once = nearestError_m(hierarchy, view);
  EXPECT_NEAR(once, 1000 / view.lens.focalPx(), 0.01 * once);  // looking straight down
  view.tau_px = 2;
  EXPECT_NEAR(nearestError_m(hierarchy, view), 2 * once, 0.01 * once);
}

}  // namespace
}  // namespace foreland::lab
