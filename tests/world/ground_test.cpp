// A camera that is steered near the ground while heights arrive: from relief, or from the server's exact replies. The
// truth is the scene at full resolution.
#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>
#include <random>

#include "client/ground/sweep.h"
#include "client/ground_supply.h"
#include "server/view/ground.h"
#include "sim/world.h"
#include "tests/support/globe_scene.h"
#include "tests/support/scene.h"
#include "tests/support/seed.h"

namespace foreland::test {
namespace {

using sim::ClientOptions;
using sim::World;

constexpr double kClearance_m = 2;

// Steered at random, always a little downward, as a page does it: the heights are those that the last frame brought.
struct Camera {
  std::shared_ptr<const terrain::Scene> scene;
  std::mt19937 random;
  client::GroundSupply supply{};
  client::GroundFeed feed{};
  proto::FrameTransform frame{scene->frame()};
  glm::dvec3 eye{0}, ahead{40, 0, -30};
  uint64_t frames = 0, known = 0, touched = 0;
  double min_m = 1e9;

  void step(client::Viewer& viewer) {
    if (random() % 90 == 0) {
      const double turn = static_cast<double>(random() % 1000) / 1000 * 6.28;
      ahead = {40 * std::cos(turn), 40 * std::sin(turn), -30};
    }
    const proto::LatticePosition here = frame.toLattice(eye);
    const auto& shape = scene->grid().shape();
    if (here.x < 30 || here.y < 30 || here.x > shape.samples_x - 31.0 || here.y > shape.samples_y - 31.0) {
      // Back to the middle, which is where the frame's origin is.
      const double away_m = std::hypot(eye.x, eye.y);
      ahead = {-40 * eye.x / away_m, -40 * eye.y / away_m, -30};
    }
    const glm::dvec3 to = eye + ahead / 60.0;
    const proto::LatticePosition p = frame.toLattice(to);
    const auto layer = viewer.tiles().layers().empty() ? std::nullopt : std::optional(viewer.tiles().layers()[0]);
    if (feed.heights().cellAt({p.x, p.y})) {
      const glm::dvec3 at = client::sweep(feed.heights(), frame, eye, to, kClearance_m);
      touched += at != to ? 1 : 0;
      eye = at;
      judge();
    }
    if (viewer.isGreeted()) feed.take(supply.update(viewer, eye, 4), layer);
    ++frames;
  }
  void judge() {
    const proto::LatticePosition p = frame.toLattice(eye);
    const auto cell = feed.heights().cellAt({p.x, p.y});
    if (!cell || cell->side > 1) return;
    ++known;
    min_m = std::min(min_m, p.height_m - server::groundHeight(*scene, p.x, p.y).value());
  }
};

class Ground : public testing::TestWithParam<bool> {};

TEST_P(Ground, ACameraStaysAboveTheTruthWhileHeightsArrive) {
  const auto seed = static_cast<uint32_t>(randomSeed());
  const auto scene = makeScene(701, 560, 17);
  Camera camera{.scene = scene, .random = std::mt19937(seed)};
  camera.eye =
      camera.frame.toScene(proto::LatticePosition{300, 250, server::groundHeight(*scene, 300, 250).value() + 40});
  ClientOptions client;
  client.request.lens = {1.0471975511965976, 640, 400};
  client.request.relief = GetParam();
  client.up.latency = client.down.latency = Duration::milliseconds(30);
  client.camera = [&](Time) { return proto::Pose{.eye = camera.eye}; };
  client.at_frame = [&](client::Viewer& viewer, Time) { camera.step(viewer); };
  World world(scene, {}, Duration::milliseconds(4), seed);
  world.addClient(client);
  world.run(Time::seconds(25));
  EXPECT_EQ(world.report(), "");
  EXPECT_GT(camera.known, camera.frames * 9 / 10);
  EXPECT_GT(camera.touched, 200u);
  EXPECT_GE(camera.min_m, kClearance_m - 0.02);
}

// Eyes near a cube's edges and corners know the ground of their own face, as far as it goes.
TEST(GroundOfAGlobe, IsThatOfTheEyesFace) {
  const auto scene = makeGlobeScene(6, 23);
  const double side = scene->grid().rootSize();
  client::GroundSupply supply;
  client::GroundFeed feed;
  glm::dvec2 at(0);
  int frames = 0, known = 0;
  const proto::FrameTransform frame(scene->frame());
  const auto eye = [&] {
    return frame.toScene(proto::LatticePosition{at.x, at.y, server::groundHeight(*scene, at.x, at.y).value() + 5});
  };
  const auto judge = [&](double face) {
    for (double y = std::max(0.0, at.y - 3); y <= std::min(side, at.y + 3); y += 0.25)
      for (double x = std::max(0.0, at.x - 3); x < std::min((face + 1) * side, at.x + 3); x += 0.25) {
        const auto cell = feed.heights().cellAt({x, y});
        if (x < face * side || !cell || cell->side > 1) continue;
        ++known;
        ASSERT_NEAR(feed.heights().heightAt({x, y}).value(), server::groundHeight(*scene, x, y).value(), 0.01)
            << x << ", " << y;
      }
  };
  ClientOptions client;
  client.request.relief = false;
  client.camera = [&](Time) { return proto::Pose{.eye = eye()}; };
  client.at_frame = [&](client::Viewer& viewer, Time) {
    constexpr int kFrames = 40;
    const int place = frames / kFrames, face = place / 4 % 6;
    if (frames % kFrames == 0) {
      at = {face * side + (place % 2 == 0 ? 1.3 : side - 1.3), place / 2 % 2 == 0 ? 0.7 : side - 0.7};
      viewer.jump();
    }
    if (viewer.isGreeted()) feed.take(supply.update(viewer, eye(), 4), std::nullopt);
    if (++frames % kFrames == 0) judge(face);
  };
  World world(scene, {}, Duration::milliseconds(4), 3);
  world.addClient(client);
  world.run(Time::seconds(18));
  EXPECT_EQ(world.report(), "");
  EXPECT_GT(known, 24 * 250);
}

INSTANTIATE_TEST_SUITE_P(Sources, Ground, testing::Bool(),
                         [](const auto& p) { return p.param ? "Relief" : "ExactReplies"; });

}  // namespace
}  // namespace foreland::test
