// Whole flights in virtual time: the laws of a session, whatever the link does.
#include <gtest/gtest.h>

#include <cmath>
#include <utility>

#include "oracle/crack_checker.h"
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

proto::Lens smallLens() { return {1.0471975511965976, 480, 270}; }

proto::Path tourOver(const terrain::Scene& scene, const char* name, double seconds) {
  auto path = server::planTour(scene, name, seconds);
  CHECK_TRUE(path.ok());
  return *path;
}

ClientOptions flying(const terrain::Scene& scene, const char* tour, Strategy strategy, Predictor predictor) {
  ClientOptions c;
  c.request.lens = smallLens();
  c.request.strategy = strategy;
  c.request.predictor = predictor;
  c.path = tourOver(scene, tour, 60);
  c.announce_path = predictor == Predictor::kKnownPath;
  return c;
}

struct Case {
  Strategy strategy;
  Predictor predictor;
  const char* tour;
};

void PrintTo(const Case& c, std::ostream* out) {
  *out << proto::name(c.strategy) << ' ' << proto::name(c.predictor) << ' ' << c.tour;
}

// A viewer that draws nothing differs in nothing that the server sees, nor in what it holds.
TEST(Flight, IsTheSameWithEmptyMeshes) {
  const auto scene = alps();
  struct Flown {
    uint64_t bytes;
    client::ViewerStatistics statistics;
    proto::Section section;
    size_t max_triangles = 0;
  };
  const auto fly = [&](bool has_meshes) {
    World world(scene, {}, Duration::milliseconds(4), 1);
    ClientOptions client = flying(*scene, "canyon", Strategy::kPredict, Predictor::kConstantVelocity);
    if (!has_meshes) client.at_frame = [](client::Viewer& viewer, Time) { viewer.leaveMeshesEmpty(); };
    world.addClient(client);
    Flown flown{};
    world.on_frame = [&](size_t, const client::FrameView& view, Time) {
      if (view.mesh) flown.max_triangles = std::max(flown.max_triangles, view.mesh->triangleCount());
    };
    world.run(Time::seconds(3));
    world.loseConnection(0);
    world.connectAgain(0);
    world.run(Time::seconds(6));
    flown.bytes = world.bytesHash(0);
    flown.statistics = world.viewer(0).statistics();
    flown.section = world.viewer(0).replica()->section();
    return flown;
  };
  const Flown drawn = fly(true), empty = fly(false);
  EXPECT_GT(drawn.max_triangles, 1000u);
  EXPECT_EQ(empty.max_triangles, 0u);
  EXPECT_EQ(empty.bytes, drawn.bytes);
  EXPECT_EQ(empty.section.slots, drawn.section.slots);
  EXPECT_EQ(empty.statistics.resumed, 1u);
  EXPECT_EQ(empty.statistics.keyframes, drawn.statistics.keyframes);
  EXPECT_EQ(empty.statistics.late_keyframes, drawn.statistics.late_keyframes);
  EXPECT_EQ(empty.statistics.frames, drawn.statistics.frames);
  EXPECT_EQ(empty.statistics.frames_outside, drawn.statistics.frames_outside);
}

class EveryStrategy : public testing::TestWithParam<Case> {};

TEST_P(EveryStrategy, KeepsTheLawsOnAGoodLink) {
  const auto scene = alps();
  World world(scene, {}, Duration::milliseconds(4), 1);
  world.addClient(flying(*scene, GetParam().tour, GetParam().strategy, GetParam().predictor));
  uint64_t frames = 0, cracks = 0;
  uint32_t checked = 0;
  world.on_frame = [&](size_t, const client::FrameView& view, Time) {
    ++frames;
    if (view.mesh_version < checked + 5) return;  // every fifth mesh
    checked = view.mesh_version;
    cracks += oracle::findCracks(*view.mesh, scene->grid().shape()).cracks;
  };
  world.run(Time::seconds(12));
  EXPECT_EQ(world.report(), "");
  EXPECT_EQ(cracks, 0u);
  EXPECT_GT(frames, 650u);
  EXPECT_GE(world.viewer(0).statistics().keyframes, 55u);
  EXPECT_EQ(world.viewer(0).statistics().late_keyframes, 0u);
}

INSTANTIATE_TEST_SUITE_P(World, EveryStrategy,
                         testing::Values(Case{Strategy::kPredict, Predictor::kKnownPath, "survey"},
                                         Case{Strategy::kPredict, Predictor::kHold, "spin"},
                                         Case{Strategy::kPredict, Predictor::kConstantVelocity, "canyon"},
                                         Case{Strategy::kPredict, Predictor::kConstantAcceleration, "orbit"},
                                         Case{Strategy::kDelay, Predictor::kHold, "survey"},
                                         Case{Strategy::kCurrent, Predictor::kHold, "canyon"}));

TEST(World, ErrorAtEachKeyframeIsAtMostTau) {
  const auto scene = alps();
  World world(scene, {}, Duration::milliseconds(4), 2);
  world.addClient(flying(*scene, "canyon", Strategy::kPredict, Predictor::kKnownPath));
  oracle::Oracle oracle(oracle::truthOf(scene));
  uint32_t checked = 0;
  double worst_px = 0;
  world.on_frame = [&](size_t, const client::FrameView& view, Time) {
    if (view.mesh->to.index == checked) return;
    checked = view.mesh->to.index;
    const oracle::DrawnShare drawn{view.mesh, 1, 1};
    const auto error = oracle.error({&drawn, 1}, view.mesh->to.pose, smallLens());
    EXPECT_EQ(error.uncovered, 0u);
    EXPECT_LE(error.max_px, view.mesh->to.tau_px * (1 + 1e-4)) << "keyframe " << checked;
    worst_px = std::max(worst_px, error.max_px);
  };
  world.run(Time::seconds(10));
  EXPECT_EQ(world.report(), "");
  EXPECT_GT(worst_px, 0.2) << "a bound that is never approached is not tested";
}

TEST(World, ErrorInEveryFrameIsAtMostTauOnAKnownPath) {
  const auto scene = alps();
  for (const char* tour : {"survey", "canyon", "spin", "orbit"}) {
    World world(scene, {}, Duration::milliseconds(4), 3);
    world.addClient(flying(*scene, tour, Strategy::kPredict, Predictor::kKnownPath));
    oracle::Oracle oracle(oracle::truthOf(scene));
    uint64_t frame = 0, judged = 0;
    double worst_px = 0;
    world.on_frame = [&](size_t, const client::FrameView& view, Time now) {
      if (now < Time::seconds(1) || ++frame % 7 != 0) return;
      const oracle::DrawnShare drawn{view.mesh, view.weight, 1};
      const auto error = oracle.error({&drawn, 1}, view.pose, smallLens());
      ++judged;
      EXPECT_LE(error.max_px, 1 + 1e-4) << tour << " at " << now.toSeconds() << " s";
      EXPECT_EQ(error.uncovered, 0u) << tour << " at " << now.toSeconds() << " s";
      EXPECT_GT(error.samples, 1000u) << tour << " at " << now.toSeconds() << " s";
      worst_px = std::max(worst_px, error.max_px);
    };
    world.run(Time::seconds(5));
    EXPECT_GE(judged, 30u) << tour << ": 60 frames a second for 4 s, of which every 7th is judged, are 34";
    EXPECT_GE(worst_px, 0.5) << tour << ": a bound that is never approached is not tested";
    EXPECT_EQ(world.report(), "");
    EXPECT_EQ(world.viewer(0).statistics().frames_outside, 0u) << tour;
  }
}

// Two eyes that look the same way, each as far from the camera as the viewer says: one section serves both.
TEST(World, ErrorIsAtMostWhatIsStatedForEachEyeOfAHead) {
  constexpr double kRadius_m = 15;
  const auto scene = alps();
  World world(scene, {}, Duration::milliseconds(4), 3);
  ClientOptions client = flying(*scene, "canyon", Strategy::kPredict, Predictor::kConstantVelocity);
  client.request.eye_radius_m = kRadius_m;
  world.addClient(client);
  oracle::Oracle oracle(oracle::truthOf(scene));
  uint64_t frames = 0, stated = 0;
  world.on_frame = [&](size_t, const client::FrameView& view, Time now) {
    if (now < Time::seconds(1) || ++frames % 7 != 0 || std::isinf(view.tolerance_px)) return;
    ++stated;
    const oracle::DrawnShare drawn{view.mesh, view.weight, 1};
    for (const double side : {-kRadius_m, kRadius_m}) {
      const proto::Pose eye{view.pose.eye + side * view.pose.right(), view.pose.orientation};
      EXPECT_LE(oracle.error({&drawn, 1}, eye, smallLens()).max_px, view.tolerance_px * (1 + 1e-4)) << now.us;
    }
  };
  world.run(Time::seconds(5));
  EXPECT_EQ(world.report(), "");
  EXPECT_GE(stated, 20u);
}

// A window that grows, a zoom, and a field of view that widens: until the keyframes for the new lens are there, a frame
// states what its own lens makes of their errors, or that nothing is guaranteed.
TEST(World, FramesStateTheErrorThroughTheLensThatTheyAreDrawnWith) {
  const auto scene = alps();
  oracle::Oracle oracle(oracle::truthOf(scene));
  World world(scene, {}, Duration::milliseconds(4), 1);
  world.addClient(flying(*scene, "canyon", Strategy::kPredict, Predictor::kKnownPath));
  const proto::Lens lenses[] = {
      smallLens(), {smallLens().vertical_fov_rad, 960, 540}, {0.3, 480, 270}, {1.6, 480, 270}, smallLens()};
  size_t coarser = 0, outside = 0, judged = 0, lens = 0;
  world.on_frame = [&](size_t, const client::FrameView& view, Time now) {
    const auto wanted = static_cast<size_t>(now.us / 1'000'000) % std::size(lenses);
    if (std::exchange(lens, wanted) != wanted) {
      proto::ViewRequest request = world.viewer(0).request();
      request.lens = lenses[wanted];
      return world.changeRequest(0, request);  // what was drawn just now was drawn with the lens before
    }
    if (now < Time::seconds(1)) return;
    if (std::isinf(view.tolerance_px)) return void(++outside);
    ++judged;
    coarser += view.tolerance_px > 1.001F;
    const oracle::DrawnShare drawn{.mesh = view.mesh, .weight = view.weight};
    EXPECT_LE(oracle.error({&drawn, 1}, view.pose, lenses[wanted]).max_px, view.tolerance_px + 1e-3) << now.us;
  };
  world.run(Time::seconds(6));
  EXPECT_GT(coarser, 10u);
  EXPECT_GT(outside, 10u);
  EXPECT_GT(judged, 200u);
}

TEST(World, FramesOutsideTheGuaranteedRegionAreCounted) {
  const auto scene = alps();
  World world(scene, {}, Duration::milliseconds(4), 4);
  ClientOptions c = flying(*scene, "survey", Strategy::kPredict, Predictor::kHold);
  // The camera stands still, then jumps, which no predictor can foresee.
  for (size_t i = 0; i < c.path.poses.size(); ++i)
    c.path.poses[i].eye = c.path.poses[0].eye + glm::dvec3(i < 50 ? 0 : 400, 0, 0);
  world.addClient(c);
  world.run(Time::seconds(4.5));
  EXPECT_EQ(world.viewer(0).statistics().frames_outside, 0u);
  world.run(Time::seconds(8));
  EXPECT_GT(world.viewer(0).statistics().frames_outside, 5u);
  EXPECT_LT(world.viewer(0).statistics().frames_outside, 60u);
  EXPECT_EQ(world.report(), "");
}

TEST(World, TheSameSeedGivesTheSameBytes) {
  const auto scene = alps();
  const auto fly = [&](uint64_t seed) {
    World world(scene, {}, Duration::milliseconds(4), seed);
    ClientOptions c = flying(*scene, "survey", Strategy::kPredict, Predictor::kConstantVelocity);
    c.up.jitter = c.down.jitter = Duration::milliseconds(30);
    world.addClient(c);
    world.run(Time::seconds(10));
    EXPECT_EQ(world.report(), "");
    return world.bytesHash(0);
  };
  EXPECT_EQ(fly(5), fly(5));
  EXPECT_NE(fly(5), fly(6));
}

TEST(World, SeveralViewersOnBadLinksEachHoldTheServersSection) {
  const auto scene = alps();
  World world(scene, {}, Duration::milliseconds(6), 7);
  const char* tours[] = {"survey", "canyon", "spin", "orbit"};
  for (int i = 0; i < 4; ++i) {
    ClientOptions c = flying(*scene, tours[i], static_cast<Strategy>(i % 3), static_cast<Predictor>(i % 3));
    c.clock_offset = Duration::milliseconds(100'000 * i);
    c.path.start = Time{} + c.clock_offset;
    c.up = {Duration::milliseconds(40), Duration::milliseconds(50), 4000, {}, {}};
    c.down = {Duration::milliseconds(60), Duration::milliseconds(80), 30'000.0 * (i + 1), Duration::milliseconds(5000),
              Duration::milliseconds(700)};
    world.addClient(c);
  }
  world.run(Time::seconds(40));
  EXPECT_EQ(world.report(), "");
  for (size_t i = 0; i < 4; ++i) EXPECT_GT(world.viewer(i).statistics().keyframes, 80u) << i;
}

TEST(World, ASlowLinkGetsFewerKeyframesAndStaysCurrent) {
  const auto scene = alps();
  World world(scene, {}, Duration::milliseconds(4), 8);
  ClientOptions c = flying(*scene, "canyon", Strategy::kPredict, Predictor::kConstantVelocity);
  c.down.bytes_per_second = 12'000;
  world.addClient(c);
  Duration worst{};
  Time first{};
  world.on_frame = [&](size_t, const client::FrameView& view, Time now) {
    if (first == Time{}) first = now;
    if (now > first + Duration::milliseconds(10'000)) worst = std::max(worst, now - view.shown_time);
  };
  world.run(Time::seconds(60));
  EXPECT_EQ(world.report(), "");
  EXPECT_GT(world.session(0).statistics().skipped_keyframes, 0u);
  EXPECT_LT(worst, Duration::milliseconds(3000)) << "what is shown falls ever further behind";
}

TEST(World, ATriangleBudgetIsKeptAndAStepOfItIsFollowedWithoutOscillation) {
  const auto scene = alps();
  World world(scene, {}, Duration::milliseconds(4), 21);
  ClientOptions c = flying(*scene, "orbit", Strategy::kPredict, Predictor::kKnownPath);
  c.request.tau_px = 0.25;
  constexpr uint32_t kSmall = 6000;
  c.at_frame = [](client::Viewer& viewer, Time now) {
    const uint32_t wanted = now > Time::seconds(6) ? kSmall : 3 * kSmall;
    if (viewer.request().max_triangles == wanted) return;
    proto::ViewRequest request = viewer.request();
    request.max_triangles = wanted;
    viewer.setRequest(request);
  };
  world.addClient(c);
  std::vector<float> taus;
  uint32_t seen = 0;
  world.on_frame = [&](size_t, const client::FrameView& view, Time now) {
    if (view.mesh->to.index == seen || now < Time::seconds(7)) return;
    seen = view.mesh->to.index;
    taus.push_back(view.mesh->to.tau_px);
    EXPECT_LE(view.mesh->triangleCount(), kSmall) << now.toSeconds();
  };
  world.run(Time::seconds(20));
  EXPECT_EQ(world.report(), "");
  ASSERT_GT(taus.size(), 50u);
  // On a circle around a summit the view changes slowly; a control that swings would turn many times.
  int turns = 0;
  for (size_t i = 2; i < taus.size(); ++i)
    turns += (taus[i] - taus[i - 1]) * (taus[i - 1] - taus[i - 2]) < -1e-6 ? 1 : 0;
  EXPECT_LE(turns, static_cast<int>(taus.size()) / 4);
  for (size_t i = 1; i < taus.size(); ++i) EXPECT_LE(std::fabs(std::log(taus[i] / taus[i - 1])), 0.16);
}

TEST(World, AByteBudgetIsKeptOnceTheToleranceHasAdapted) {
  const auto scene = alps();
  World world(scene, {}, Duration::milliseconds(4), 22);
  ClientOptions c = flying(*scene, "canyon", Strategy::kPredict, Predictor::kKnownPath);
  c.request.tau_px = 0.5;
  c.request.max_bytes_per_second = 600;
  world.addClient(c);
  double max_tau_px = 0;
  world.on_frame = [&](size_t, const client::FrameView& view, Time) {
    max_tau_px = std::max<double>(max_tau_px, view.mesh->to.tau_px);
  };
  world.run(Time::seconds(15));
  const uint64_t before = world.viewer(0).statistics().bytes_down;
  world.run(Time::seconds(45));
  EXPECT_EQ(world.report(), "");
  EXPECT_LE((world.viewer(0).statistics().bytes_down - before) / 30.0, 600 * 1.1);
  EXPECT_GT(max_tau_px, 0.5);
}

TEST(World, StrategiesSwitchInFlightWithoutAJump) {
  const auto scene = alps();
  World world(scene, {}, Duration::milliseconds(4), 9);
  ClientOptions c = flying(*scene, "canyon", Strategy::kPredict, Predictor::kConstantVelocity);
  c.at_frame = [](client::Viewer& viewer, Time now) {
    const auto wanted = static_cast<Strategy>((now.us / 4'000'000) % 3);
    if (viewer.request().strategy == wanted) return;
    proto::ViewRequest request = viewer.request();
    request.strategy = wanted;
    viewer.setRequest(request);
  };
  world.addClient(c);
  // A new mesh begins with the section that the old one ends with, and its interval begins at the end of the old one's
  // or later. So the last frame of the old mesh is less than a frame before the end of its interval, and the first
  // frame of the new one less than a frame after the beginning of its own. Weights grow by at most one frame's share of
  // an interval a frame, and no interval is shorter than kShortestBlend.
  constexpr double kShare = World::kFrame.toSeconds() / client::Timeline::kShortestBlend.toSeconds() + 1e-6;
  uint32_t version = 0, last_to = 0, changes = 0;
  float last_weight = 0;
  world.on_frame = [&](size_t, const client::FrameView& view, Time) {
    if (version != 0 && view.mesh_version != version) {
      EXPECT_EQ(view.mesh_version, version + 1);
      EXPECT_EQ(view.mesh->from.index, last_to);
      EXPECT_GE(last_weight, 1 - kShare) << "the old mesh was left before its end";
      EXPECT_LE(view.weight, kShare) << "the new mesh was not shown from its beginning";
      ++changes;
    }
    version = view.mesh_version;
    last_to = view.mesh->to.index;
    last_weight = view.weight;
  };
  world.run(Time::seconds(30));
  EXPECT_EQ(world.report(), "");
  EXPECT_GT(changes, 100u);
}

}  // namespace
}  // namespace foreland::test
