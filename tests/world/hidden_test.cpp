// A flight among objects and ridges, most of which are hidden: what is seen keeps the tolerance in every frame, judged
// by lines of sight that share nothing with the server's; both ends hold the same; and less is sent.
#include <gtest/gtest.h>

#include "oracle/line_of_sight.h"
#include "oracle/scene_truth.h"
#include "sim/world.h"
#include "tests/support/hiding_spheres.h"
#include "tests/support/scene.h"
#include "tests/support/seed.h"

namespace foreland::test {
namespace {

using sim::World;

const HidingSpheres& spheres() {
  static const HidingSpheres all;
  return all;
}

// Some two hundred spheres on low hills, large ones and small ones.
class HiddenWorld {
 public:
  explicit HiddenWorld(server::Occlusion occlusion) : rng_(randomSeed()) {
    FormulaSource source(129, 129, [](uint32_t x, uint32_t y) { return 6 * std::sin(0.07 * x) * std::cos(0.05 * y); });
    scene_ = makeScene(source);
    for (int i = 0; i < 250; ++i) {
      const glm::dvec2 at(rng_.uniform(20, 108), rng_.uniform(20, 108));
      const double scale = i % 4 == 0 ? rng_.uniform(15, 30) : rng_.uniform(4, 9);
      if (std::abs(at.y - 64) * 10 < scale + 20) continue;  // the path leads there
      placements_.push_back(
          {0, frame_().toScene(proto::LatticePosition{at.x, at.y, scale * 0.7}), {1, 0, 0, 0}, scale});
    }
    auto world = std::make_shared<server::World>(scene_, spheres().at(placements_));
    if (occlusion != server::Occlusion::kOff)
      world->occlusion = server::SceneOcclusion::create(world->hierarchy).value();
    world_ = world;
  }

  sim::ClientOptions client() const {
    sim::ClientOptions options;
    options.request.lens = {1.05, 960, 540};
    options.request.tau_px = 1;
    options.request.predictor = proto::Predictor::kKnownPath;
    options.request.keyframe_interval = Duration::milliseconds(200);
    options.request.occlusion = true;
    options.path = {Time{}, Duration::milliseconds(500), {}};
    options.announce_path = true;
    for (int i = 0; i <= 60; ++i) {
      const glm::dvec3 eye = frame_().toScene(proto::LatticePosition{15 + 0.6 * i, 64, 14});
      options.path.poses.push_back({eye, proto::lookAlong({1, 0.4 * std::sin(0.2 * i), -0.02}, {0, 0, 1})});
    }
    return options;
  }

  const std::shared_ptr<const terrain::Scene>& scene() const { return scene_; }
  const std::shared_ptr<const server::World>& world() const { return world_; }
  const server::SceneObjects& objects() const { return world_->hierarchy.objects(); }

 private:
  proto::FrameTransform frame_() const { return proto::FrameTransform(scene_->frame()); }

  Rng rng_;
  std::shared_ptr<const terrain::Scene> scene_;
  std::vector<proto::ObjectPlacement> placements_;
  std::shared_ptr<const server::World> world_;
};

struct Flown {
  uint64_t bytes = 0, frames = 0, over = 0, samples = 0;
  size_t hidden_objects = 0;
  double worst = 0;
};

Flown fly(const HiddenWorld& hidden, server::Occlusion occlusion, bool is_cut) {
  World world(
      hidden.world(), {.occlusion = occlusion}, [](const sim::StepWork&) { return Duration::milliseconds(4); }, 1);
  const sim::ClientOptions options = hidden.client();
  world.addClient(options);
  const oracle::Truth truth = oracle::truthOf(hidden.scene());
  const oracle::LineOfSight ground(truth);
  oracle::SceneOracle oracle(truth, oracle::objectsTruth(hidden.objects().set, hidden.objects().nodes));
  oracle.judgeOnlySeen([&](const glm::dvec3& point, const glm::dvec3& eye) {
    const glm::dvec3 nearer = point + 0.02 * glm::normalize(eye - point);
    return ground.isClear(nearer, eye) &&
           !spheres().isBetween(hidden.objects(), spheres().full, hidden.objects().set.size(), eye, nearer);
  });
  Flown flown;
  world.on_frame = [&](size_t, const client::FrameView& view, Time) {
    flown.hidden_objects = std::max(flown.hidden_objects, world.session(0).statistics().hidden_objects);
    if (flown.frames++ % 23 != 0 || std::isinf(view.tolerance_px)) return;
    const oracle::SceneDeviation d =
        oracle.error(*view.mesh, view.weight, view.pose, options.request.lens, view.tolerance_px);
    flown.worst = std::max(flown.worst, d.max_px / view.tolerance_px);
    flown.samples += d.samples;
  };
  world.on_keyframe = [&](size_t, const sim::ArrivedKeyframe& keyframe) { flown.bytes += keyframe.bytes; };
  for (double t = 3; t <= 15; t += 3) {
    world.run(Time::seconds(t));
    if (!is_cut || t == 15) continue;
    world.loseConnection(0);
    world.run(Time::seconds(t + 0.2));
    world.connectAgain(0);
  }
  EXPECT_EQ(world.report(), "");
  return flown;
}

TEST(Hidden, WhatIsSeenKeepsTheToleranceAndLessIsSent) {
  const HiddenWorld with(server::Occlusion::kAuto);
  const Flown all = fly(with, server::Occlusion::kOff, false), seen = fly(with, server::Occlusion::kAuto, false);
  EXPECT_GT(seen.samples, 10'000u);
  EXPECT_LE(seen.worst, 1.001);
  EXPECT_GT(seen.worst, 0.2) << "an oracle that sees nothing finds nothing";
  EXPECT_GT(seen.hidden_objects, 3u);
  EXPECT_EQ(all.hidden_objects, 0u);
}

TEST(Hidden, SectionsWithoutWhatIsHiddenAreResumed) {
  const HiddenWorld with(server::Occlusion::kAuto);
  const Flown seen = fly(with, server::Occlusion::kAuto, true);
  EXPECT_LE(seen.worst, 1.001);
  EXPECT_GT(seen.hidden_objects, 3u);
}

}  // namespace
}  // namespace foreland::test
