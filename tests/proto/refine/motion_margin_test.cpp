// The law of margins: a result of the refinement test stands until the motions it is sensitive to have used up its
// slack, whatever the camera does. The flights here judge by passes() alone.
#include "proto/refine/metric/motion_margin.h"

#include <gtest/gtest.h>

#include <array>
#include <glm/geometric.hpp>
#include <glm/gtc/quaternion.hpp>

#include "base/rng.h"

namespace foreland::proto {
namespace {

struct Node {
  glm::dvec3 at;
  double radius_m, error_m;
};

// A camera that keeps its habits: how it moves, climbs and turns, and how its region and tolerance change.
class Flight {
 public:
  explicit Flight(Rng& rng) : rng_(rng) {
    view_.lens.vertical_fov_rad = rng.uniform(0.3, 1.8);
    view_.lens.width_px = static_cast<uint32_t>(200 + rng.below(2000));
    view_.lens.height_px = static_cast<uint32_t>(200 + rng.below(1200));
    view_.tau_px = rng.uniform(0.3, 8);
    const double yaw = rng.uniform(-3.2, 3.2), pitch = rng.uniform(-1.5, 1.5);
    view_.pose.orientation =
        glm::angleAxis(yaw, glm::dvec3(0, 0, 1)) * glm::angleAxis(1.5 + pitch, glm::dvec3(1, 0, 0));
    view_.region_radius_m = rng.below(2) ? rng.uniform(0, 20) : 0;
    view_.region_angle_rad = rng.below(3) == 0 ? rng.uniform(0, 0.4) : 0;
    const auto maybe = [&](double most) { return rng.below(3) == 0 ? rng.uniform(-most, most) : 0.0; };
    ahead_ = rng.below(4) == 0 ? maybe(30) : rng.uniform(0, 30);
    aside_ = maybe(10), climb_ = maybe(10), turn_ = maybe(0.05), growth_ = maybe(0.5), scale_ = maybe(0.02);
  }

  const View& view() const { return view_; }

  // The next view, by steps that differ a little.
  void step() {
    const double pace = rng_.uniform(0.5, 1.5);
    const glm::dvec3 forward = view_.pose.forward();
    const glm::dvec3 level = glm::normalize(glm::dvec3(forward.x, forward.y, 1e-12));
    view_.pose.eye +=
        pace * (ahead_ * level + aside_ * glm::dvec3(-level.y, level.x, 0) + climb_ * glm::dvec3(0, 0, 1));
    const glm::dvec3 axis = glm::normalize(glm::dvec3(rng_.uniform(-1, 1), rng_.uniform(-1, 1), 2));
    view_.pose.orientation = glm::normalize(glm::angleAxis(pace * turn_, axis) * view_.pose.orientation);
    view_.region_radius_m = std::max(0.0, view_.region_radius_m + growth_ * rng_.uniform(-1, 1));
    view_.region_angle_rad = std::max(0.0, view_.region_angle_rad + 0.1 * turn_ * rng_.uniform(-1, 1));
    view_.tau_px *= 1 + scale_ * rng_.uniform(-1, 1);
  }

 private:
  Rng& rng_;
  View view_;
  double ahead_, aside_, climb_, turn_, growth_, scale_;
};

NodePosition positionOf(const Metric& m, const glm::dvec3& at) {
  const glm::dvec3 p = at - m.eye();
  return {m.frustum().toView(p.x, p.y, p.z), std::hypot(p.x, p.y)};
}

bool passes(const View& view, bool vertical, const Node& node) {
  const Metric m(view, vertical);
  return m.passes(positionOf(m, node.at), node.radius_m, node.error_m);
}

// Somewhere about the camera, with an error about which the test is in doubt.
Node randomNode(const View& view, bool vertical, Rng& rng) {
  const Metric m(view, vertical);
  const double distance = std::exp(rng.uniform(2, 9));
  const glm::dvec3 at = view.pose.eye + distance * (view.pose.forward() + rng.uniform(-1.2, 1.2) * view.pose.right() +
                                                    rng.uniform(-0.8, 0.8) * view.pose.up());
  const double radius = distance * rng.uniform(0, 0.2), least = m.minError(positionOf(m, at), radius);
  const double error = std::isinf(least) ? rng.uniform(0, 10) : least * std::exp(rng.uniform(-0.5, 0.5));
  return {at, radius, error};
}

// Flies on while the slack lasts. Returns the steps that it lasted.
int flyOut(Flight flight, bool vertical, const Node& node, Sensitivity sensitivity, double slack,
           const std::string& what) {
  const bool passed = passes(flight.view(), vertical, node);
  const double max_distance =
      glm::distance(node.at, flight.view().pose.eye) + MotionMargin::maxGrowthOfDistance(sensitivity, slack);
  for (int steps = 0; steps < 50; ++steps) {
    const View last = flight.view();
    flight.step();
    slack -= MotionMargin(Metric(last, vertical))
                 .motionBoundTo(last, flight.view())
                 .of(static_cast<size_t>(sensitivity), max_distance);
    if (slack < 0) return steps;
    EXPECT_LE(glm::distance(node.at, flight.view().pose.eye), max_distance) << what << ", step " << steps;
    EXPECT_EQ(passes(flight.view(), vertical, node), passed) << what << ", step " << steps << ", slack left " << slack;
    if (testing::Test::HasFailure()) return steps;
  }
  return 50;
}

TEST(MotionMargin, ResultsStandAsLongAsTheirSlackLasts) {
  const uint64_t seed = static_cast<uint64_t>(testing::UnitTest::GetInstance()->random_seed());
  Rng rng(seed);
  std::array<int, MotionBound::kSensitivities> taken{}, steps{};
  for (int i = 0; i < 40000 && !HasFailure(); ++i) {
    Flight flight(rng);
    const bool vertical = rng.below(3) > 0;
    const Metric m(flight.view(), vertical);
    Flight next = flight;
    next.step();
    const MotionMargin margin(m);
    const MotionBound motion = margin.motionBoundTo(flight.view(), next.view());
    const Node node = randomNode(flight.view(), vertical, rng);
    const TestResult testResult = margin.testResult(positionOf(m, node.at), node.radius_m, node.error_m, motion);
    const auto sensitivity = static_cast<size_t>(testResult.sensitivity);
    EXPECT_GE(testResult.slack, 0);
    ++taken[sensitivity];
    steps[sensitivity] += flyOut(flight, vertical, node, testResult.sensitivity, testResult.slack,
                                 "seed " + std::to_string(seed) + ", case " + std::to_string(i) + ", sensitivity " +
                                     std::to_string(sensitivity));
  }
  for (size_t sensitivity = 0; sensitivity < MotionBound::kSensitivities; ++sensitivity) {
    EXPECT_GT(taken[sensitivity], 100) << "sensitivity " << sensitivity << ", seed " << seed;
    EXPECT_GT(steps[sensitivity], taken[sensitivity]) << "sensitivity " << sensitivity << ", seed " << seed;
  }
}

}  // namespace
}  // namespace foreland::proto
