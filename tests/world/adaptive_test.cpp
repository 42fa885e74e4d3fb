// Adaptive keyframes in virtual time: the guarantees are those of fixed intervals, whatever the intervals are.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <string>

#include "oracle/oracle.h"
#include "oracle/scene_truth.h"
#include "server/view/tour.h"
#include "sim/world.h"
#include "tests/support/scene.h"
#include "tests/world/alps.h"

namespace foreland::test {
namespace {

using sim::ClientOptions;
using sim::World;

using proto::Predictor;
using proto::Strategy;

constexpr Duration kShortest = Duration::milliseconds(100), kLongest = Duration::milliseconds(800);

ClientOptions flying(const char* tour, Strategy strategy, Predictor predictor) {
  ClientOptions c;
  c.request.lens = {1.0471975511965976, 480, 270};
  c.request.strategy = strategy;
  c.request.predictor = predictor;
  c.request.keyframe_interval = kShortest;
  c.request.longest_interval = kLongest;
  c.path = server::planTour(*alps(), tour, 60).value();
  c.announce_path = predictor == Predictor::kKnownPath;
  return c;
}

// Of keyframes that were not skipped, in the order of their times.
struct Gaps {
  std::optional<Time> last;
  std::vector<Duration> all;
  void add(Time t) {
    if (last && t > *last) all.push_back(t - *last);
    if (!last || t > *last) last = t;
  }
};

TEST(Adaptive, KeyframesLieOnTheGridOfTheShortestAndNoFurtherApartThanTheLongest) {
  std::map<std::string, Duration> longest;
  for (const char* tour : {"survey", "spin"}) {
    World world(alps(), {}, Duration::milliseconds(4), 1);
    world.addClient(flying(tour, Strategy::kPredict, Predictor::kConstantVelocity));
    Gaps gaps;
    world.on_frame = [&](size_t, const client::FrameView& view, Time) { gaps.add(view.mesh->to.time); };
    world.run(Time::seconds(15));
    EXPECT_EQ(world.report(), "");
    EXPECT_EQ(world.session(0).statistics().skipped_keyframes, 0u) << tour;
    EXPECT_EQ(world.viewer(0).statistics().late_keyframes, 0u) << tour;
    ASSERT_GT(gaps.all.size(), 15u) << tour;
    for (const Duration gap : gaps.all) {
      EXPECT_EQ(gap.us % kShortest.us, 0) << tour;
      EXPECT_LE(gap, kLongest) << tour;
    }
    longest[tour] = *std::max_element(gaps.all.begin(), gaps.all.end());
  }
  EXPECT_EQ(longest["spin"], kShortest) << "everything changes where the camera spins";
  EXPECT_GE(longest["survey"], kShortest * 3) << "an interval that never changes does not adapt";
}

TEST(Adaptive, ErrorInEveryFrameIsAtMostTauOnAKnownPath) {
  for (const char* tour : {"survey", "canyon", "spin", "orbit"}) {
    World world(alps(), {}, Duration::milliseconds(4), 3);
    const ClientOptions c = flying(tour, Strategy::kPredict, Predictor::kKnownPath);
    world.addClient(c);
    oracle::Oracle oracle(oracle::truthOf(alps()));
    uint64_t frame = 0, judged = 0;
    double worst_px = 0;
    world.on_frame = [&](size_t, const client::FrameView& view, Time now) {
      if (now < Time::seconds(1) || ++frame % 7 != 0) return;
      const oracle::DrawnShare drawn{view.mesh, view.weight, 1};
      const auto error = oracle.error({&drawn, 1}, view.pose, c.request.lens);
      ++judged;
      EXPECT_LE(error.max_px, 1 + 1e-4) << tour << " at " << now.toSeconds() << " s";
      EXPECT_EQ(error.uncovered, 0u) << tour << " at " << now.toSeconds() << " s";
      worst_px = std::max(worst_px, error.max_px);
    };
    world.run(Time::seconds(5));
    EXPECT_GE(judged, 30u) << tour;
    EXPECT_GE(worst_px, 0.5) << tour << ": a bound that is never approached is not tested";
    EXPECT_EQ(world.report(), "");
    EXPECT_EQ(world.viewer(0).statistics().frames_outside, 0u) << tour;
  }
}

// Rather than guarantee less for long, keyframes follow each other sooner where regions would be reduced. A camera that
// looks from side to side is predicted badly.
TEST(Adaptive, GuaranteesHoldInMostFramesOfACameraThatLooksAround) {
  struct Swing {
    double angle_rad, rate;
  };
  for (const Swing swing : {Swing{0.2, 1.0}, {0.3, 1.0}, {0.6, 0.5}}) {
    World world(alps(), {}, Duration::milliseconds(50), 9);
    ClientOptions c = flying("canyon", Strategy::kPredict, Predictor::kConstantVelocity);
    c.camera = [tour = c.path, swing](Time t) {
      proto::Pose pose = tour.at(t);
      const double side_rad = swing.angle_rad * std::sin(swing.rate * t.toSeconds());
      pose.orientation = glm::angleAxis(side_rad, glm::dvec3(0, 0, 1)) * pose.orientation;
      return pose;
    };
    world.addClient(c);
    world.run(Time::seconds(30));
    EXPECT_EQ(world.report(), "");
    const auto& s = world.viewer(0).statistics();
    EXPECT_LE(s.frames_outside, s.frames / 10) << swing.angle_rad;
    EXPECT_LE(world.session(0).statistics().keyframes, 200u) << "the shortest gives 300";
  }
}

TEST(Adaptive, WhatDelayAndCurrentShowNeverStandsStill) {
  for (const Strategy strategy : {Strategy::kDelay, Strategy::kCurrent}) {
    World world(alps(), {}, Duration::milliseconds(4), 5);
    world.addClient(flying("survey", strategy, Predictor::kHold));
    std::optional<Time> last;
    uint64_t frames = 0;
    world.on_frame = [&](size_t, const client::FrameView& view, Time now) {
      if (now < Time::seconds(4)) return;
      if (last) {
        EXPECT_GT(view.shown_time, *last) << now.toSeconds();
        EXPECT_LE(now - view.shown_time, kLongest + Duration::milliseconds(200)) << now.toSeconds();
      }
      last = view.shown_time;
      ++frames;
    };
    world.run(Time::seconds(12));
    EXPECT_EQ(world.report(), "");
    EXPECT_GT(frames, 450u);
  }
}

TEST(Adaptive, AViewerMayChangeBetweenFixedAndAdaptive) {
  World world(alps(), {}, Duration::milliseconds(4), 7);
  const ClientOptions c = flying("survey", Strategy::kPredict, Predictor::kConstantVelocity);
  world.addClient(c);
  world.run(Time::seconds(6));
  proto::ViewRequest fixed = c.request;
  fixed.keyframe_interval = Duration::milliseconds(250);
  fixed.longest_interval = {};
  world.changeRequest(0, fixed);
  world.run(Time::seconds(8));
  Gaps gaps;
  world.on_frame = [&](size_t, const client::FrameView& view, Time) { gaps.add(view.mesh->to.time); };
  world.run(Time::seconds(12));
  ASSERT_GE(gaps.all.size(), 12u);
  for (const Duration gap : gaps.all) EXPECT_EQ(gap, Duration::milliseconds(250));
  world.changeRequest(0, c.request);
  world.run(Time::seconds(16));
  EXPECT_EQ(world.report(), "");
}

}  // namespace
}  // namespace foreland::test
