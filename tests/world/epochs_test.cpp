// Scenes that change in time, server and client together: whatever way scene time goes, every frame keeps its error
// guarantee against the ground at that time.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <map>

#include "oracle/crack_checker.h"
#include "oracle/epoch_shares.h"
#include "oracle/scene_truth.h"
#include "sim/world.h"
#include "terrain/dem/open.h"
#include "tests/support/data.h"
#include "tests/support/scene.h"
#include "tests/support/seed.h"
#include "tests/world/ring_of_objects.h"

namespace foreland::test {
namespace {

using sim::ClientOptions;
using sim::onKnownTour;
using sim::World;

constexpr double kDay = 86'400;

std::shared_ptr<const terrain::Scene> movingScene(uint64_t seed, proto::FrameKind kind = proto::FrameKind::kPlanar,
                                                  proto::EpochBlend blend = proto::EpochBlend::kLinear) {
  return makeMovingScene(201, 173, seed, 6, kind, blend);
}

// Judges what a world's client shows.
class Judge {
 public:
  explicit Judge(std::shared_ptr<const terrain::Scene> scene, const server::SceneObjects& objects = {})
      : scene_(scene), oracle_(oracle::truthOf(scene), oracle::objectsTruth(objects.set, objects.nodes)) {}

  // Every mesh for cracks and for the heights of its vertices, and every seventh frame against the truth.
  void judge(const client::FrameView& view, const proto::Lens& lens) {
    const client::KeyframeMesh& mesh = *view.mesh;
    if (std::exchange(version_, view.mesh_version) != view.mesh_version) {
      cracks_ += oracle::findCracks(mesh, scene_->grid().shape()).cracks;
      checkHeights(mesh);
      scene_times_.push_back(mesh.to.scene_time);
      const bool moves = mesh.from.scene_time != mesh.to.scene_time;
      steps_ += moves && mesh.to.is_scene_step ? 1 : 0;
      jumps_ += moves && !mesh.to.is_scene_step ? 1 : 0;
    }
    if (frames_++ % 7 != 0 || std::isinf(view.tolerance_px)) return;
    const oracle::SceneDeviation d = oracle_.error(mesh, view.weight, view.pose, lens, mesh.to.frameTolerance());
    worst_ = std::max(worst_, d.max_px / view.tolerance_px);
    uncovered_ += d.uncovered;
    samples_ += d.samples;
    object_vertices_ += d.object_vertices;
    moving_ += mesh.from.scene_time != mesh.to.scene_time ? 1 : 0;
  }

  void keep(const client::Replica& replica) { sections_[replica.newest().index] = replica.section(); }

  void expectSound() const {
    EXPECT_EQ(cracks_, 0u);
    EXPECT_EQ(uncovered_, 0u);
    EXPECT_EQ(wrong_heights_, 0u);
    EXPECT_GT(samples_, 10'000u);
    EXPECT_TRUE(hasSeenMotion()) << moving_ << " frames in which the ground moved";
    EXPECT_LE(worst_, 1.001) << "of the tolerance";
    EXPECT_GT(worst_, 0.2) << "an oracle that sees nothing moves nobody";
  }
  bool hasSeenMotion() const { return moving_ > 20; }
  uint64_t objectVertices() const { return object_vertices_; }
  uint64_t steps() const { return steps_; }
  uint64_t jumps() const { return jumps_; }
  const std::vector<Time>& sceneTimes() const { return scene_times_; }

 private:
  // A node of the section is drawn at the height of the ground at the keyframe's scene time; its ancestors are in the
  // section, too.
  void checkHeights(const client::KeyframeMesh& mesh) {
    const proto::GridTopology& grid = scene_->grid();
    const proto::Section& section = sections_[mesh.to.index];
    std::vector<Time> dates;
    for (const proto::Epoch& epoch : scene_->epochs().epochs().all()) dates.push_back(epoch.time);
    const std::vector<double> shares =
        oracle::epochShares(dates, scene_->epochs().epochs().blend(), mesh.to.scene_time);
    for (uint32_t i : mesh.indices) {
      const glm::vec2 p = mesh.parameters[i];
      const proto::NodeId v = proto::NodeId::at(static_cast<uint32_t>(p.x), static_cast<uint32_t>(p.y));
      if (glm::vec2(v.x(), v.y()) != p) continue;  // where a triangle was cut at the data's border
      if (!grid.isBase(v) && !proto::contains(section, grid.slot(v))) continue;
      double quanta = scene_->height(v);
      for (uint32_t epoch = 0; epoch < shares.size(); ++epoch)
        if (shares[epoch] != 0) quanta += shares[epoch] * scene_->epochs().offset(epoch, grid, v);
      const double metres = quanta * scene_->frame().height_quantum_m;
      if (std::fabs(mesh.to_positions[i].w - metres) > 1e-3) ++wrong_heights_;
    }
  }

  std::shared_ptr<const terrain::Scene> scene_;
  oracle::SceneOracle oracle_;
  std::map<uint32_t, proto::Section> sections_;  // by keyframe
  uint32_t version_ = 0;
  uint64_t frames_ = 0, cracks_ = 0, uncovered_ = 0, samples_ = 0, wrong_heights_ = 0, moving_ = 0,
           object_vertices_ = 0, steps_ = 0, jumps_ = 0;
  double worst_ = 0;
  std::vector<Time> scene_times_;
};

void attach(World& world, Judge& judge, const ClientOptions& options) {
  world.on_frame = [&, lens = options.request.lens](size_t, const client::FrameView& view, Time) {
    judge.judge(view, lens);
  };
  world.on_keyframe = [&](size_t i, const sim::ArrivedKeyframe&) { judge.keep(*world.viewer(i).replica()); };
}

std::string blendName(proto::EpochBlend blend) {
  constexpr std::array kNames{"Linear", "CatmullRom", "BSpline"};
  return kNames[static_cast<size_t>(blend)];
}

struct Ground {
  proto::FrameKind kind;
  proto::EpochBlend blend;
};

class MovingGround : public ::testing::TestWithParam<Ground> {};

// Scene time stops, runs, runs backwards, is dragged and jumps; objects are carried by the ground.
TEST_P(MovingGround, KeepsTheToleranceWhicheverWayTimeGoes) {
  const uint64_t seed = randomSeed();
  SCOPED_TRACE(seed);
  Rng rng(seed);
  const auto scene = movingScene(seed, GetParam().kind, GetParam().blend);
  const proto::Epochs& epochs = scene->epochs().epochs();
  const server::SceneObjects objects = objectsIn(*scene, 3);
  uint64_t clocks = 0;
  World world(scene, {}, Duration::milliseconds(4), seed, objectsIn(*scene, 3));
  ClientOptions options = onKnownTour(*scene, rng.below(2) == 0 ? "orbit" : "survey", 30);
  options.at_frame = [&](client::Viewer& viewer, Time now) {
    if (rng.below(60) != 0) return;
    const auto span = static_cast<double>((epochs.last() - epochs.first()).us);
    proto::SceneClock clock{now, epochs.clamp(static_cast<double>(epochs.first().us) + rng.uniform(0, span)), 0};
    if (rng.below(4) != 0) clock.rate = rng.uniform(-60, 120) * kDay;
    if (viewer.replica() && rng.below(2) != 0) clock.scene_time = viewer.replica()->newest().scene_time;
    viewer.setSceneClock(clock);
    ++clocks;
  };
  Judge judge(scene, objects);
  attach(world, judge, options);
  world.addClient(options);
  // The clock may stand at the first or last epoch for long.
  for (int64_t s = 12; s <= 28 && (s == 12 || !judge.hasSeenMotion()); s += 4) world.run(Time::seconds(s));
  EXPECT_EQ(world.report(), "");
  judge.expectSound();
  if (GetParam().blend == proto::EpochBlend::kLinear) return;
  EXPECT_GT(judge.steps(), 3u);
  EXPECT_LE(judge.jumps(), clocks) << "only the first keyframe by a clock jumps";
}

INSTANTIATE_TEST_SUITE_P(Frames, MovingGround,
                         ::testing::Values(Ground{proto::FrameKind::kPlanar, proto::EpochBlend::kLinear},
                                           Ground{proto::FrameKind::kGeographic, proto::EpochBlend::kLinear},
                                           Ground{proto::FrameKind::kPlanar, proto::EpochBlend::kCatmullRom},
                                           Ground{proto::FrameKind::kGeographic, proto::EpochBlend::kCatmullRom},
                                           Ground{proto::FrameKind::kPlanar, proto::EpochBlend::kBSpline},
                                           Ground{proto::FrameKind::kGeographic, proto::EpochBlend::kBSpline}),
                         [](const auto& instance) {
                           const std::string frame =
                               instance.param.kind == proto::FrameKind::kPlanar ? "Planar" : "Geographic";
                           return frame + blendName(instance.param.blend);
                         });

// As far up and down as the ground under each of them moves, and no farther.
TEST(MovingGroundWithObjects, CarriesThem) {
  for (const uint64_t seed : {2, 3, 9}) {
    const auto scene = movingScene(seed);
    const proto::Epochs& epochs = scene->epochs().epochs();
    const server::SceneObjects objects = objectsIn(*scene, 6);
    const auto farthest_m = [&](const proto::ObjectPlacement& p) {
      double most = 0;
      for (const proto::Epoch& epoch : epochs.all())
        most = std::max(most, glm::length(p.rise.at(epochs.weightsAt(epoch.time))));
      return most;
    };
    const auto all = objects.set.placements();
    EXPECT_GE(std::count_if(all.begin(), all.end(), [&](const auto& p) { return farthest_m(p) > 10; }), 2);
    World world(scene, {}, Duration::milliseconds(4), seed, objectsIn(*scene, 6));
    ClientOptions options = onKnownTour(*scene, "orbit", 20);
    bool is_set = false;
    options.at_frame = [&](client::Viewer& viewer, Time now) {
      if (!std::exchange(is_set, true)) viewer.setSceneClock({now, epochs.first(), 60 * kDay});
    };
    Judge judge(scene, objects);
    attach(world, judge, options);
    world.addClient(options);
    world.run(Time::seconds(10));
    EXPECT_EQ(world.report(), "");
    judge.expectSound();
    EXPECT_GT(judge.objectVertices(), 1'000u);
  }
}

// All samples, row by row from the south; NaN where there are none.
std::vector<float> samplesOf(terrain::ElevationSource& source) {
  std::vector<float> all(size_t{source.info().width} * source.info().height);
  CHECK_TRUE(source.readRows(0, source.info().height, all).ok());
  return all;
}

// A real landslide, a day long: its valley before, and with the difference that was measured after it.
TEST(Landslide, KeepsTheToleranceWhileItFalls) {
  FORELAND_DATA_OR_SKIP(before_file, "dem/misc/pre_runout_DEM.asc");
  FORELAND_DATA_OR_SKIP(difference_file, "dem/misc/DEM_of_Difference.asc");
  const auto before = terrain::openElevation({before_file}, {}),
             difference = terrain::openElevation({difference_file}, {});
  ASSERT_TRUE(before.ok() && difference.ok());
  const std::vector<float> heights = samplesOf(**before), changes = samplesOf(**difference);
  const terrain::ElevationInfo& info = (*before)->info();
  FormulaSource after(info.width, info.height, [&](uint32_t x, uint32_t y) {
    const size_t i = size_t{y} * info.width + x;
    return double{heights[i]} + double{changes[i]};
  });
  after.info() = info;
  const Time first{}, last = first + Duration::seconds(kDay);
  const auto scene = makeScene(**before, 0.1, 1, {{first, "before", nullptr}, {last, "after", &after}});
  double max_m = 0;
  for (const float change : changes) max_m = std::max(max_m, std::isnan(change) ? 0.0 : std::fabs(double{change}));
  EXPECT_GT(max_m, 1);

  World world(scene, {}, Duration::milliseconds(4), 1);
  ClientOptions options = onKnownTour(*scene, "orbit", 20);
  bool is_set = false;
  options.at_frame = [&](client::Viewer& viewer, Time now) {
    if (!std::exchange(is_set, true)) viewer.setSceneClock({now, first, 0.2 * kDay});
  };
  Judge judge(scene);
  attach(world, judge, options);
  world.addClient(options);
  world.run(Time::seconds(8));
  EXPECT_EQ(world.report(), "");
  EXPECT_EQ(judge.sceneTimes().back(), last);
  judge.expectSound();
}

// Resumed on another server in mid-time, again and again.
TEST(MovingGroundLost, IsResumedInMidTime) {
  const uint64_t seed = randomSeed();
  SCOPED_TRACE(seed);
  Rng rng(seed);
  const auto scene =
      movingScene(seed, proto::FrameKind::kPlanar, proto::epochBlendOf(static_cast<uint32_t>(rng.below(3))).value());
  World world(scene, {}, Duration::milliseconds(4), seed);
  ClientOptions options = onKnownTour(*scene, "orbit", 30);
  bool is_set = false;
  options.at_frame = [&](client::Viewer& viewer, Time now) {
    if (!std::exchange(is_set, true)) viewer.setSceneClock({now, scene->epochs().epochs().first(), 40 * kDay});
  };
  Judge judge(scene);
  attach(world, judge, options);
  world.addClient(options);
  double t = 1;
  for (int i = 0; i < 6; ++i) {
    world.run(Time::seconds(t += rng.uniform(0.3, 1.5)));
    world.loseConnection(0);
    world.run(Time::seconds(t += rng.uniform(0, 0.4)));
    world.connectAgain(0);
  }
  world.run(Time::seconds(t + 2));
  EXPECT_EQ(world.report(), "");
  EXPECT_GE(world.viewer(0).statistics().resumed, 4u);
  judge.expectSound();
}

// While the clock runs, no keyframe passes an epoch that none has shown; in the end the last epoch is shown.
TEST(SceneTime, StopsAtEveryEpochOnItsWay) {
  const auto scene = movingScene(5);
  const proto::Epochs& epochs = scene->epochs().epochs();
  for (const double days_per_s : {7.0, 90.0, 100'000.0, -90.0}) {
    World world(scene, {}, Duration::milliseconds(4), 5);
    ClientOptions options = onKnownTour(*scene, "orbit", 60);
    bool is_set = false;
    options.at_frame = [&](client::Viewer& viewer, Time now) {
      if (!std::exchange(is_set, true))
        viewer.setSceneClock({now, days_per_s > 0 ? epochs.first() : epochs.last(), days_per_s * kDay});
    };
    Judge judge(scene);
    attach(world, judge, options);
    world.addClient(options);
    world.run(Time::seconds(8));
    EXPECT_EQ(world.report(), "");
    const std::vector<Time>& times = judge.sceneTimes();
    for (size_t i = 1; i < times.size(); ++i)
      for (const proto::Epoch& epoch : epochs.all())
        EXPECT_FALSE(std::min(times[i - 1], times[i]) < epoch.time && epoch.time < std::max(times[i - 1], times[i]));
    if (std::fabs(days_per_s) > 80) {
      EXPECT_EQ(times.back(), days_per_s > 0 ? epochs.last() : epochs.first());
    } else {
      EXPECT_NEAR((times.back() - times.front()).toSeconds() / kDay, 7 * 8, 7);
    }
  }
}

// What was sent of an epoch is not sent again: there and back costs the bytes of there.
class SceneTimeOfAnyBlend : public ::testing::TestWithParam<proto::EpochBlend> {};

TEST_P(SceneTimeOfAnyBlend, IsSentOnceThereAndBack) {
  const auto scene = movingScene(6, proto::FrameKind::kPlanar, GetParam());
  const proto::Epochs& epochs = scene->epochs().epochs();
  World world(scene, {}, Duration::milliseconds(4), 6);
  ClientOptions options = onKnownTour(*scene, "orbit", 60);
  if (GetParam() != proto::EpochBlend::kLinear) options.request.tau_px = 16;
  const proto::Pose still = options.path.poses.front();
  options.camera = [still](Time) { return still; };
  std::optional<proto::SceneClock> next;
  options.at_frame = [&](client::Viewer& viewer, Time now) {
    if (!next) return;
    next->at = now;
    viewer.setSceneClock(*next);
    next.reset();
  };
  world.addClient(options);
  world.run(Time::seconds(2));
  const auto bytes = [&] { return world.viewer(0).statistics().bytes_down; };
  const uint64_t begun = bytes();
  double now_s = 2;
  const auto runUntil = [&](Time scene_time) {
    const auto shown = [&] { return world.viewer(0).replica()->newest().scene_time; };
    for (const double last_s = now_s + 300; now_s < last_s && shown() != scene_time;)
      world.run(Time::seconds(now_s += 5));
    EXPECT_EQ(shown(), scene_time);
  };
  next = {Time{}, epochs.first(), 150 * kDay};
  runUntil(epochs.last());
  const uint64_t there = bytes() - begun;
  next = {Time{}, epochs.last(), -150 * kDay};
  runUntil(epochs.first());
  const uint64_t back = bytes() - begun - there;
  // Steps of cubic blends are shorter, so there are more headers.
  EXPECT_GT(there, (GetParam() == proto::EpochBlend::kLinear ? 4 : 2) * back);
  EXPECT_EQ(world.report(), "");
}

INSTANTIATE_TEST_SUITE_P(Blends, SceneTimeOfAnyBlend,
                         ::testing::Values(proto::EpochBlend::kLinear, proto::EpochBlend::kCatmullRom,
                                           proto::EpochBlend::kBSpline),
                         [](const auto& instance) { return blendName(instance.param); });

}  // namespace
}  // namespace foreland::test
