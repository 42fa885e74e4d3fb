// Tours of any scene stay above its ground: of a few hundred metres or of the whole earth, level or steep.
#include "server/view/tour.h"

#include <gtest/gtest.h>

#include <cmath>

#include "base/rng.h"
#include "server/view/ground.h"
#include "server/view/tour_plans.h"
#include "tests/support/scene.h"
#include "tests/support/seed.h"
#include "tests/support/sparse_scene.h"

namespace foreland::server {
namespace {

constexpr double kDegree = 0.017453292519943295;
constexpr std::array<const char*, 4> kTours{"survey", "canyon", "spin", "orbit"};

// The middle of a scene of so many degrees along both axes at a latitude.
void placeOnEarth(proto::Frame& frame, const terrain::ElevationInfo& info, double latitude, double degrees_x,
                  double degrees_y) {
  frame.kind = proto::FrameKind::kGeographic;
  frame.longitude_step_rad = degrees_x * kDegree / (info.width - 1);
  frame.latitude_step_rad = degrees_y * kDegree / (info.height - 1);
  frame.longitude0_rad = 20 * kDegree;
  frame.latitude0_rad = (latitude - 0.5 * degrees_y) * kDegree;
  frame.origin = {latitude * kDegree, (20 + 0.5 * degrees_x) * kDegree, 0};
}

// Hills as steep as a tenth of the distance between samples allows, or level ground, on any frame.
std::shared_ptr<const terrain::Scene> someScene(Rng& rng) {
  const auto width = static_cast<uint32_t>(20 + rng.below(200)), height = static_cast<uint32_t>(20 + rng.below(200));
  const double spacing_m = std::exp(rng.uniform(0, std::log(1000.0)));
  const bool is_planar = rng.below(2) == 0;
  const double metres = std::min(9000.0, rng.uniform(0, is_planar ? spacing_m / 10 : 200));
  const auto ground = test::hills(rng.below(1u << 30));
  test::FormulaSource source(width, height, [=](uint32_t x, uint32_t y) { return ground(x, y) / 600 * metres; });
  proto::Frame& frame = source.info().frame;
  frame.axis_x_m = {spacing_m, 0}, frame.axis_y_m = {0, spacing_m};
  if (!is_planar) {
    const double degrees_y = std::exp(rng.uniform(std::log(0.1), std::log(170.0)));
    const double latitude = rng.uniform(-0.5, 0.5) * (179 - degrees_y);
    const double degrees_x = rng.below(2) == 0 ? 360 : std::exp(rng.uniform(std::log(0.1), std::log(360.0)));
    placeOnEarth(frame, source.info(), latitude, degrees_x, degrees_y);
  }
  return test::makeScene(source);
}

std::shared_ptr<const terrain::Scene> wholeEarth() {
  test::FormulaSource source(361, 181,
                             [](uint32_t x, uint32_t y) { return 4000 * std::sin(x / 9.0) * std::cos(y / 7.0); });
  placeOnEarth(source.info().frame, source.info(), 0, 360, 179.9);
  return test::makeScene(source);
}

TEST(Tour, StaysAboveTheGround) {
  Rng rng(test::randomSeed());
  for (int i = 0; i < 12; ++i) {
    const auto scene = someScene(rng);
    for (const char* name : kTours) {
      const auto path = planTour(*scene, name, 90);
      ASSERT_TRUE(path.ok());
      ASSERT_TRUE(path->validate().ok()) << name << " of scene " << i;
      for (Time t; t < path->end(); t = t + Duration::milliseconds(20))
        ASSERT_GT(heightAboveGround(*scene, path->at(t).eye), 0)
            << name << " of scene " << i << " at " << t.toSeconds();
    }
  }
}

TEST(Tour, OverTheWholeEarthStaysAboveTheGround) {
  const auto scene = wholeEarth();
  for (const char* name : kTours) {
    const auto path = planTour(*scene, name, 600).value();
    for (Time t; t < path.end(); t = t + Duration::milliseconds(20))
      ASSERT_GT(heightAboveGround(*scene, path.at(t).eye), 0) << name << " at " << t.toSeconds();
  }
}

// Wherever it is on the earth.
TEST(Tour, FliesAlongTheGroundOfTheWholeEarth) {
  const auto scene = wholeEarth();
  const proto::FrameTransform frame(scene->frame());
  const auto path = planTour(*scene, "survey", 300).value();
  const auto footOf = [&](const proto::Pose& pose) {
    proto::LatticePosition at = frame.toLattice(pose.eye);
    at.height_m = 0;
    return frame.toScene(at);
  };
  const double first_m = glm::distance(footOf(path.poses[1]), footOf(path.poses[0]));
  EXPECT_GT(first_m, 10 * 15) << "samples are far apart";
  for (size_t i = 0; i + 1 < path.poses.size(); ++i) {
    const proto::Pose& pose = path.poses[i];
    EXPECT_NEAR(glm::distance(footOf(path.poses[i + 1]), footOf(pose)) / first_m, 1, 0.25) << i;
    EXPECT_NEAR(glm::dot(pose.forward(), frame.upAt(pose.eye)), std::sin(-12 * kDegree), 1e-6) << i;
  }
}

// Samples 160 m apart, but for a disc on the survey's first leg, where they lie 10 m apart: a quarter of the pace.
constexpr test::Disc kFine{1024, 310, 60};

std::shared_ptr<const terrain::Scene> fineInPlaces(proto::FrameKind kind) {
  const auto level = [](uint32_t x, uint32_t y) { return 300 + 50 * std::sin(x / 300.0) * std::cos(y / 200.0); };
  return test::makeSparseScene(2049, 1025, level, kind, 4, {kFine});
}

struct Leg {
  double from_fine, speed, above;  // samples, m/s, m
};

std::vector<Leg> legsOf(const terrain::Scene& scene, const proto::Path& path) {
  const proto::FrameTransform frame(scene.frame());
  std::vector<Leg> legs;
  for (size_t i = 0; i + 1 < path.poses.size(); ++i) {
    const glm::dvec3 eye = path.poses[i].eye, next = path.poses[i + 1].eye;
    const proto::LatticePosition at = frame.toLattice(eye);
    legs.push_back({std::hypot(at.x - kFine.x, at.y - kFine.y), 10 * glm::length(glm::dvec2(next - eye)),
                    heightAboveGround(scene, eye)});
  }
  return legs;
}

TEST(Tour, IsSlowAndLowOverFineGroundAndFastOverCoarse) {
  for (const auto kind : {proto::FrameKind::kPlanar, proto::FrameKind::kGeographic}) {
    const auto scene = fineInPlaces(kind);
    double slowest = 1e9, fastest = 0, lowest = 1e9, highest = 0, jump = 0, last = 0;
    for (const Leg& leg : legsOf(*scene, planTour(*scene, "survey", 300).value())) {
      slowest = std::min(slowest, leg.speed), fastest = std::max(fastest, leg.speed);
      if (last > 0) jump = std::max(jump, std::fabs(leg.speed - last));
      last = leg.speed;
      if (leg.from_fine < 0.5 * kFine.radius) lowest = std::min(lowest, leg.above);
      if (leg.from_fine > 700) highest = std::max(highest, leg.above);
    }
    EXPECT_LT(lowest, 0.4 * highest);
    EXPECT_NEAR(slowest / fastest, 0.25, 0.03);
    EXPECT_LT(jump, 0.05 * fastest) << "no camera brakes within a moment";
  }
}

TEST(Tour, StaysAboveGroundThatIsFineInPlaces) {
  const uint64_t seed = test::randomSeed();
  for (const auto kind : {proto::FrameKind::kPlanar, proto::FrameKind::kGeographic}) {
    const auto scene =
        test::makeSparseScene(801, 401, test::hills(seed % 1000), kind, 3, {{400, 200, 40}, {400, 90, 60}});
    for (const char* name : kTours) {
      const auto path = planTour(*scene, name, 90).value();
      for (Time t; t < path.end(); t = t + Duration::milliseconds(20))
        ASSERT_GT(heightAboveGround(*scene, path.at(t).eye), 0) << name << " at " << t.toSeconds() << ", seed " << seed;
    }
  }
}

// Where nothing is finer than the rest, tours are those over a scene that has as much everywhere.
TEST(Tour, IsTheSameOverScenesThatNowhereAreFiner) {
  const auto formula = [](uint32_t x, uint32_t y) { return 300 + 50 * std::sin(x / 300.0) * std::cos(y / 200.0); };
  const auto sparse = test::makeSparseScene(2049, 1025, formula, proto::FrameKind::kPlanar, 4, {});
  test::FormulaSource source(129, 65, [&](uint32_t x, uint32_t y) { return formula(16 * x, 16 * y); });
  source.info().frame.anchor = {64, 32};
  source.info().frame.axis_x_m = {160, 0}, source.info().frame.axis_y_m = {0, 160};
  const auto whole = test::makeScene(source);
  for (const char* name : {"survey", "canyon"}) {
    const proto::Path a = planTour(*sparse, name, 60).value(), b = planTour(*whole, name, 60).value();
    for (size_t i = 0; i < a.poses.size(); i += 10)
      EXPECT_LT(glm::distance(glm::dvec2(a.poses[i].eye), glm::dvec2(b.poses[i].eye)), 1) << name << ' ' << i;
  }
}

void expectEqual(const proto::Path& a, const proto::Path& b) {
  ASSERT_EQ(a.poses.size(), b.poses.size());
  for (size_t i = 0; i < a.poses.size(); ++i)
    EXPECT_TRUE(a.poses[i].eye == b.poses[i].eye && a.poses[i].orientation == b.poses[i].orientation) << i;
}

TEST(TourPlans, AreThoseOfOneViewerAndMadeOnce) {
  Rng rng(test::randomSeed());
  const auto scene = someScene(rng);
  TourPlans plans(*scene);
  for (int i = 0; i < 40; ++i) {
    const std::string name = kTours[rng.below(kTours.size())];
    const double seconds = 1 + static_cast<double>(rng.below(8));
    const auto plan = plans.plan(name, seconds, Time{} + Duration::seconds(i));
    expectEqual(*plan, planTour(*scene, name, seconds).value());
    EXPECT_EQ(plans.plan(name, seconds, Time{} + Duration::seconds(1000)), plan) << "it is kept";
  }
  const auto oldest = plans.plan("survey", 20, Time{});
  for (size_t i = 0; i < TourPlans::kMost; ++i) (void)plans.plan("survey", 30 + static_cast<double>(i), Time{});
  EXPECT_NE(plans.plan("survey", 20, Time{}), oldest) << "no more than kMost are kept";
  EXPECT_NE(plans.plan("spin", 700, Time{}), plans.plan("spin", 700, Time{})) << "long ones take memory";
}

}  // namespace
}  // namespace foreland::server
