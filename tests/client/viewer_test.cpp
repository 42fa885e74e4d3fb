// What a viewer counts, held against a count of its frames from outside.
#include "client/viewer.h"

#include <gtest/gtest.h>

#include "sim/world.h"
#include "tests/support/scene.h"

namespace foreland::test {
namespace {

using sim::ClientOptions;
using sim::onKnownTour;
using sim::World;

// Whether the camera is within the region of a keyframe's error guarantee, by formulas of our own. Cases within
// rounding of the border are left out.
enum class Side : uint8_t { kInside, kOutside, kBorder };

Side sideOf(const proto::KeyframeHeader& k, const proto::Pose& camera) {
  const double moved_m = glm::length(k.pose.eye - camera.eye);
  const double turned_rad = 2 * std::acos(std::min(1.0, std::fabs(glm::dot(k.pose.orientation, camera.orientation))));
  const double over = std::max(moved_m - k.region_radius_m, 1e3 * (turned_rad - k.region_angle_rad));
  return std::fabs(over) < 1e-4 ? Side::kBorder : over > 0 ? Side::kOutside : Side::kInside;
}

// A camera that stands, jumps by `jump_m` after 4 s and turns by `turn_rad` after 7 s; predicted by a predictor that
// cannot foresee it.
ClientOptions jumping(const terrain::Scene& scene, double jump_m, double turn_rad) {
  ClientOptions c = onKnownTour(scene, "survey", 20);
  c.request.predictor = proto::Predictor::kHold;
  c.announce_path = false;
  const proto::Pose start = c.path.poses[0];
  for (size_t i = 0; i < c.path.poses.size(); ++i) {
    const double t = static_cast<double>(i) * c.path.step.toSeconds();
    c.path.poses[i] = start;
    if (t > 4) c.path.poses[i].eye.x += jump_m;
    if (t > 7) c.path.poses[i].orientation = glm::angleAxis(turn_rad, glm::dvec3(0, 0, 1)) * start.orientation;
  }
  return c;
}

void expectCountOfFramesOutside(double jump_m, double turn_rad, uint64_t least) {
  const auto scene = makeScene(201, 151, 42);
  World world(scene, {}, Duration::milliseconds(4), 1);
  world.addClient(jumping(*scene, jump_m, turn_rad));
  uint64_t outside = 0, border = 0, frames = 0;
  world.on_frame = [&](size_t, const client::FrameView& view, Time) {
    ++frames;
    std::vector<Side> sides;
    if (view.weight < 1) sides.push_back(sideOf(view.mesh->from, view.pose));
    if (view.weight > 0) sides.push_back(sideOf(view.mesh->to, view.pose));
    if (std::ranges::count(sides, Side::kOutside) > 0)
      ++outside;
    else if (std::ranges::count(sides, Side::kBorder) > 0)
      ++border;
  };
  world.run(Time::seconds(10));
  const client::ViewerStatistics& counted = world.viewer(0).statistics();
  EXPECT_EQ(counted.frames, frames);
  EXPECT_GE(counted.frames_outside, outside);
  EXPECT_LE(counted.frames_outside, outside + border);
  EXPECT_GE(counted.frames_outside, least);
  EXPECT_LT(counted.frames_outside, frames / 2);
}

TEST(FramesOutside, CountsFramesAfterAJump) { expectCountOfFramesOutside(300, 0, 5); }
TEST(FramesOutside, CountsFramesAfterATurn) { expectCountOfFramesOutside(0, 1, 5); }
TEST(FramesOutside, IsZeroWhileTheCameraStands) {
  const auto scene = makeScene(201, 151, 42);
  World world(scene, {}, Duration::milliseconds(4), 1);
  world.addClient(jumping(*scene, 0, 0));
  world.run(Time::seconds(10));
  EXPECT_GT(world.viewer(0).statistics().frames, 500u);
  EXPECT_EQ(world.viewer(0).statistics().frames_outside, 0u);
}

}  // namespace
}  // namespace foreland::test
