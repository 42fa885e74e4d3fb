// Guards, tried out: an outcome stands until the tolls of its own guard have used its slack up, whatever the camera
// does. The flight here calls passes() and nothing else of the test's.
#include "proto/refine/metric.h"

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

// A camera that keeps its habits: how it moves, climbs, turns, and how its promise and tolerance change.
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
    view_.ball_m = rng.below(2) ? rng.uniform(0, 20) : 0;
    view_.turn_rad = rng.below(3) == 0 ? rng.uniform(0, 0.4) : 0;
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
    view_.ball_m = std::max(0.0, view_.ball_m + growth_ * rng_.uniform(-1, 1));
    view_.turn_rad = std::max(0.0, view_.turn_rad + 0.1 * turn_ * rng_.uniform(-1, 1));
    view_.tau_px *= 1 + scale_ * rng_.uniform(-1, 1);
  }

 private:
  Rng& rng_;
  View view_;
  double ahead_, aside_, climb_, turn_, growth_, scale_;
};

Metric::Place place(const Metric& m, const glm::dvec3& at) {
  const glm::dvec3 p = at - m.eye();
  return {glm::dot(p, m.right()), glm::dot(p, m.up()), glm::dot(p, m.forward()), std::hypot(p.x, p.y)};
}

bool passes(const View& view, bool vertical, const Node& node) {
  const Metric m(view, vertical);
  return m.passes(place(m, node.at), node.radius_m, node.error_m);
}

// Somewhere about the camera, with an error about which the test is in doubt.
Node randomNode(const View& view, bool vertical, Rng& rng) {
  const Metric m(view, vertical);
  const double distance = std::exp(rng.uniform(2, 9));
  const glm::dvec3 at = view.pose.eye + distance * (view.pose.forward() + rng.uniform(-1.2, 1.2) * view.pose.right() +
                                                    rng.uniform(-0.8, 0.8) * view.pose.up());
  const double radius = distance * rng.uniform(0, 0.2), least = m.leastError(place(m, at), radius);
  const double error = std::isinf(least) ? rng.uniform(0, 10) : least * std::exp(rng.uniform(-0.5, 0.5));
  return {at, radius, error};
}

// Flies on while the slack lasts. Returns the steps that it lasted.
int flyOut(Flight flight, bool vertical, const Node& node, Metric::Guard guard, double slack, const std::string& what) {
  const bool passed = passes(flight.view(), vertical, node);
  const double reach = glm::distance(node.at, flight.view().pose.eye) + slack;
  for (int steps = 0; steps < 50; ++steps) {
    const View last = flight.view();
    flight.step();
    slack -= Metric(last, vertical).tollTo(last, flight.view()).of(static_cast<size_t>(guard), reach);
    if (slack < 0) return steps;
    EXPECT_EQ(passes(flight.view(), vertical, node), passed) << what << ", step " << steps << ", slack left " << slack;
    if (testing::Test::HasFailure()) return steps;
  }
  return 50;
}

TEST(Metric, OutcomesStandAsLongAsTheirSlackLasts) {
  const uint64_t seed = static_cast<uint64_t>(testing::UnitTest::GetInstance()->random_seed()) + 1;
  Rng rng(seed);
  std::array<int, Toll::kGuards> taken{}, steps{};
  for (int i = 0; i < 40000 && !HasFailure(); ++i) {
    Flight flight(rng);
    const bool vertical = rng.below(3) > 0;
    const Metric m(flight.view(), vertical);
    Flight next = flight;
    next.step();
    const Toll toll = m.tollTo(flight.view(), next.view());
    const Node node = randomNode(flight.view(), vertical, rng);
    const Metric::Outcome outcome = m.outcome(place(m, node.at), node.radius_m, node.error_m, toll);
    const auto guard = static_cast<size_t>(outcome.guard);
    EXPECT_GE(outcome.slack, 0);
    ++taken[guard];
    steps[guard] +=
        flyOut(flight, vertical, node, outcome.guard, outcome.slack,
               "seed " + std::to_string(seed) + ", case " + std::to_string(i) + ", guard " + std::to_string(guard));
  }
  for (size_t guard = 0; guard < Toll::kGuards; ++guard) {
    EXPECT_GT(taken[guard], 100) << "guard " << guard << ", seed " << seed;
    EXPECT_GT(steps[guard], taken[guard]) << "guard " << guard << ", seed " << seed;
  }
}

}  // namespace
}  // namespace foreland::proto
