// A camera that jumps, in virtual time: the viewer is soon back at its tolerance, states it honestly on the way, and no
// section exceeds its limit.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <utility>

#include "server/view/ground.h"
#include "server/view/region_share.h"
#include "sim/world.h"
#include "tests/support/scene.h"
#include "tests/world/alps.h"
#include "tests/world/ring_of_objects.h"

namespace foreland::test {
namespace {

using sim::ClientOptions;
using sim::World;

using proto::Strategy;

constexpr Duration kEvery = Duration::seconds(4);
constexpr size_t kMaxNodes = 30000;

glm::dvec3 aboveGround(double x, double y, double height_m) {
  return {x, y, 5000 - server::heightAboveGround(*alps(), {x, y, 5000}) + height_m};
}

// Every kEvery somewhere else, looking elsewhere; slowly flying on in between.
proto::Pose jumper(Time now) {
  static const std::array<glm::dvec3, 4> kEyes{{aboveGround(-900, -600, 300), aboveGround(900, 500, 200),
                                                aboveGround(-200, 700, 250), aboveGround(400, -800, 900)}};
  const auto view = static_cast<size_t>(std::max<int64_t>(now.us, 0) / kEvery.us);
  const double s = Duration{std::max<int64_t>(now.us, 0) % kEvery.us}.toSeconds();
  const double heading = 2.4 * static_cast<double>(view) + 0.05 * s;
  const glm::dvec3 forward(std::cos(heading), std::sin(heading), -0.6);
  return {kEyes[view % kEyes.size()] + 20 * s * glm::dvec3(forward.x, forward.y, 0),
          proto::lookAlong(forward, {0, 0, 1})};
}

ClientOptions jumping(Strategy strategy) {
  ClientOptions c;
  c.request.lens = {1.0471975511965976, 480, 270};
  c.request.strategy = strategy;
  c.request.predictor = proto::Predictor::kConstantVelocity;
  c.request.tau_px = 1;
  c.camera = jumper;
  c.up.jitter = c.down.jitter = Duration::milliseconds(10);
  return c;
}

class Jumps : public testing::TestWithParam<Strategy> {};

TEST_P(Jumps, AreSoonOverAndNoFrameClaimsMoreThanIsGuaranteed) {
  server::SessionOptions options;
  options.max_section_nodes = kMaxNodes;
  options.max_added_after_jump = 5000;
  World world(alps(), options, Duration::milliseconds(30), 51);
  world.addClient(jumping(GetParam()));
  uint64_t coarse_frames = 0, frames = 0;
  Duration worst{};
  size_t view = 0, max_nodes = 0;
  bool is_recovered = true;
  world.on_frame = [&](size_t, const client::FrameView& shown, Time now) {
    const Duration since{now.us % kEvery.us};
    if (const auto at = static_cast<size_t>(now.us / kEvery.us); at != view) {
      EXPECT_TRUE(is_recovered) << "view " << view;
      view = at;
      is_recovered = false;
    }
    max_nodes = std::max<size_t>(max_nodes, shown.mesh->to_nodes);
    if (view == 0) return;
    ++frames;
    const bool shows_view = glm::distance(shown.pose.eye, jumper(now).eye) < 50;
    const float tolerance_px = shows_view ? shown.tolerance_px : HUGE_VALF;
    if (since > Duration::milliseconds(400) && tolerance_px > 8) ++coarse_frames;
    if (!is_recovered && tolerance_px <= 1) {
      is_recovered = true;
      worst = std::max(worst, since);
    }
  };
  world.run(Time::seconds(4 * 9));
  EXPECT_EQ(world.report(), "");
  EXPECT_GT(frames, 1800u);
  EXPECT_LE(worst, Duration::milliseconds(250));
  EXPECT_EQ(coarse_frames, 0u);
  EXPECT_LE(max_nodes, kMaxNodes);
  EXPECT_EQ(world.session(0).statistics().jumps, 8u);
  EXPECT_EQ(world.viewer(0).statistics().started_afresh, 0u) << "that is for new connections";
}

// Jumps that a camera could have flown are over as soon as any other, if they are announced: a turn on the spot, by
// half a radian at most, and 300 m from far above.
TEST_P(Jumps, ThatAreSmallAreOverAsSoonIfTheyAreAnnounced) {
  struct Small {
    glm::dvec3 eye;
    double step_m, turn_rad;
  };
  for (const Small& small :
       {Small{aboveGround(-300, -200, 300), 0, 0.45}, Small{aboveGround(-300, -200, 4500), 300, 0}}) {
    World world(alps(), {}, Duration::milliseconds(30), 54);
    ClientOptions c = jumping(GetParam());
    c.camera = [&](Time now) {
      const auto view = static_cast<double>(std::max<int64_t>(now.us, 0) / kEvery.us);
      const double heading = 0.4 + small.turn_rad * view;
      return proto::Pose{small.eye + glm::dvec3(small.step_m * view, 0, 0),
                         proto::lookAlong({std::cos(heading), std::sin(heading), -0.6}, {0, 0, 1})};
    };
    int64_t view = 0;
    c.at_frame = [&](client::Viewer& viewer, Time now) {
      if (const int64_t at = std::max<int64_t>(now.us, 0) / kEvery.us; at != std::exchange(view, at)) viewer.jump();
    };
    world.addClient(c);
    Duration worst{};
    bool is_recovered = true;
    int64_t seen = 0;
    world.on_frame = [&](size_t, const client::FrameView& shown, Time now) {
      if (const int64_t at = now.us / kEvery.us; at != std::exchange(seen, at)) {
        EXPECT_TRUE(is_recovered) << "view " << at;
        is_recovered = false;
      }
      const bool shows_view = glm::distance(shown.pose.eye, c.camera(now).eye) < 50 &&
                              proto::angleBetween(shown.pose.orientation, c.camera(now).orientation) < 0.1;
      if (is_recovered || seen == 0 || !shows_view || shown.tolerance_px > 1) return;
      is_recovered = true;
      worst = std::max(worst, Duration{now.us % kEvery.us});
    };
    world.run(Time::seconds(4 * 7));
    EXPECT_EQ(world.report(), "");
    EXPECT_EQ(world.session(0).statistics().jumps, 6u);
    EXPECT_LE(worst, Duration::milliseconds(600)) << small.step_m;
  }
}

TEST_P(Jumps, ObjectsCountAgainstTheLimitOfNodes) {
  server::SessionOptions options;
  options.max_section_nodes = 3000;
  World world(alps(), options, Duration::milliseconds(10), 52, objectsIn(*alps(), 8));
  ClientOptions c = jumping(GetParam());
  c.request.tau_px = 0.05;
  world.addClient(c);
  size_t with_objects = 0;
  for (int i = 1; i < 240; ++i) {
    world.run(Time::seconds(0.1 * i));
    const server::SessionStatistics& s = world.session(0).statistics();
    ASSERT_LE(s.section_nodes, options.max_section_nodes) << i;
    with_objects += s.section_nodes > world.session(0).section().slots.size();
  }
  EXPECT_EQ(world.report(), "");
  EXPECT_GT(with_objects, 50u);
}

// The camera goes round four places, again and again. The second time round nothing is new to the viewer.
TEST_P(Jumps, BackToAKnownPlaceCostNextToNothing) {
  World world(alps(), {}, Duration::milliseconds(10), 52);
  ClientOptions c = jumping(GetParam());
  c.camera = [](Time now) { return jumper(Time{now.us % (kEvery * 4).us}); };
  world.addClient(c);
  world.run(Time{} + kEvery * 4);
  const uint64_t first_round = world.viewer(0).statistics().bytes_down;
  world.run(Time{} + kEvery * 8);
  EXPECT_EQ(world.report(), "");
  EXPECT_GE(world.session(0).statistics().jumps, 7u);
  EXPECT_LT(8 * (world.viewer(0).statistics().bytes_down - first_round), first_round);
}

// A camera that stands still, and then turns irregularly, a radian and more in a second: where predictions fail, the
// tolerance is raised and stated, and sections are not much larger than those of a viewer who announces the path.
TEST(Turns, ThatCannotBePredictedAreCoarserNotLargerAndGuaranteed) {
  static constexpr double kStill_s = 10, kEnd_s = 34;
  const auto camera = [](Time now) {
    const double s = std::max(0.0, Duration{now.us}.toSeconds() - kStill_s);
    const double heading = 1.3 * std::sin(1.1 * s) + 0.7 * std::sin(2.3 * s + 1) + 0.4 * std::sin(5.1 * s);
    return proto::Pose{aboveGround(-100 + 3 * s, 50, 200),
                       proto::lookAlong({std::cos(heading), std::sin(heading), -0.4}, {0, 0, 1})};
  };
  ClientOptions guessed = jumping(Strategy::kPredict);
  guessed.camera = camera;
  ClientOptions known = guessed;
  known.camera = {};
  known.request.predictor = proto::Predictor::kKnownPath;
  known.path = {Time{}, Duration::milliseconds(20), {}};
  for (Time t; t < Time::seconds(kEnd_s + 2); t = t + known.path.step) known.path.poses.push_back(camera(t));
  known.announce_path = true;
  World world(alps(), {}, Duration::milliseconds(10), 53);
  world.addClient(guessed);
  world.addClient(known);
  uint64_t frames = 0, outside = 0;
  world.on_frame = [&](size_t i, const client::FrameView& view, Time now) {
    if (i > 0 || now < Time::seconds(kStill_s)) return;
    ++frames;
    outside += std::isinf(view.tolerance_px) ? 1 : 0;
  };
  double nodes = 0, nodes_of_known = 0;
  for (double t = 6; t < kEnd_s; t += 0.2) {
    world.run(Time::seconds(t));
    nodes += static_cast<double>(world.session(0).section().slots.size());
    nodes_of_known += static_cast<double>(world.session(1).section().slots.size());
    EXPECT_LE(world.session(0).keyframe().tau_px, 1.001 * server::RegionShare::kCoarsest);
  }
  EXPECT_EQ(world.report(), "");
  EXPECT_LE(nodes, 1.5 * nodes_of_known);
  EXPECT_GE(nodes, 0.8 * nodes_of_known) << "it need not be as coarse";
  EXPECT_LE(outside, frames / 10);
}

INSTANTIATE_TEST_SUITE_P(World, Jumps, testing::Values(Strategy::kPredict, Strategy::kDelay, Strategy::kCurrent),
                         [](const auto& test) { return std::string(proto::name(test.param)); });

}  // namespace
}  // namespace foreland::test
