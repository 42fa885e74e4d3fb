// Laws of interpolation along a path.
#include "proto/space/path.h"

#include <gtest/gtest.h>

#include <glm/geometric.hpp>
#include <string>

#include "base/rng.h"

namespace foreland::proto {
namespace {

Path randomPath(Rng& rng) {
  Path path{Time{static_cast<int64_t>(rng.below(1u << 30))},
            Duration::milliseconds(50 + static_cast<int64_t>(rng.below(500))),
            {}};
  for (uint64_t n = 2 + rng.below(8); n > 0; --n) {
    const glm::dvec3 eye(rng.uniform(-1e4, 1e4), rng.uniform(-1e4, 1e4), rng.uniform(0, 1e3));
    const glm::dquat q(rng.uniform(-1, 1), rng.uniform(-1, 1), rng.uniform(-1, 1), rng.uniform(-1, 1));
    path.poses.push_back({eye, glm::normalize(q)});
  }
  return path;
}

class Paths : public testing::Test {
 protected:
  Paths() : seed_(static_cast<uint64_t>(testing::UnitTest::GetInstance()->random_seed())), rng_(seed_) {}
  std::string seed() const { return "seed " + std::to_string(seed_); }

 private:
  uint64_t seed_;

 protected:
  Rng rng_;
};

TEST_F(Paths, PassThroughTheirPoses) {
  SCOPED_TRACE(seed());
  for (int i = 0; i < 200; ++i) {
    const Path path = randomPath(rng_);
    ASSERT_TRUE(path.validate().ok());
    for (size_t k = 0; k < path.poses.size(); ++k) {
      const Pose at = path.at(path.start + path.step * static_cast<int64_t>(k));
      ASSERT_EQ(at.eye, path.poses[k].eye) << "pose " << k;
      ASSERT_LT(angleBetween(at.orientation, path.poses[k].orientation), 1e-7) << "pose " << k;
    }
    ASSERT_EQ(path.end(), path.start + path.step * static_cast<int64_t>(path.poses.size() - 1));
  }
}

TEST_F(Paths, HoldStillBeyondTheirEnds) {
  SCOPED_TRACE(seed());
  const Path path = randomPath(rng_);
  for (const Duration beyond : {Duration{0}, Duration{1}, Duration::milliseconds(100'000)}) {
    EXPECT_EQ(path.at(path.start - beyond).eye, path.poses.front().eye);
    EXPECT_EQ(path.at(path.end() + beyond).eye, path.poses.back().eye);
  }
}

// Catmull-Rom reproduces quadratics, exactly but for rounding, wherever it has a pose beyond either end of the
// interval.
TEST_F(Paths, FollowQuadraticMotionExactly) {
  SCOPED_TRACE(seed());
  const auto random = [&] { return glm::dvec3(rng_.uniform(-9, 9), rng_.uniform(-9, 9), rng_.uniform(-9, 9)); };
  const glm::dvec3 a = random(), b = random(), c = random();
  const auto eye = [&](double t) { return a + b * t + c * (t * t); };
  Path path{Time{1'000'000}, Duration::milliseconds(1000), {}};
  for (int k = 0; k < 6; ++k) path.poses.push_back({eye(k), {1, 0, 0, 0}});
  for (int i = 0; i < 500; ++i) {
    const Duration t{1'000'000 + static_cast<int64_t>(rng_.below(3'000'000))};
    const glm::dvec3 expected = eye(static_cast<double>(t.us) / 1e6);
    ASSERT_LT(glm::distance(path.at(path.start + t).eye, expected), 1e-9) << t.us << " us";
  }
}

// The eye has one speed on both sides of a pose.
TEST_F(Paths, HaveNoKinks) {
  SCOPED_TRACE(seed());
  for (int i = 0; i < 200; ++i) {
    const Path path = randomPath(rng_);
    for (size_t k = 1; k + 1 < path.poses.size(); ++k) {
      const Time at = path.start + path.step * static_cast<int64_t>(k);
      const glm::dvec3 before = path.at(at).eye - path.at(at - Duration{1}).eye,
                       after = path.at(at + Duration{1}).eye - path.at(at).eye;
      const double steps = static_cast<double>(path.step.us);
      // Accelerations are below 10 times the largest distance between eyes, 3e4 m, a step squared.
      ASSERT_LT(glm::distance(before, after), 3e5 / (steps * steps) + 1e-9) << "pose " << k;
    }
  }
}

// Orientations turn along the shorter arc, at an even rate.
TEST_F(Paths, TurnEvenly) {
  SCOPED_TRACE(seed());
  for (int i = 0; i < 200; ++i) {
    const Path path = randomPath(rng_);
    const glm::dquat &from = path.poses[0].orientation, &to = path.poses[1].orientation;
    const double whole = angleBetween(from, to), shorter = std::min(whole, 2 * 3.14159265358979324 - whole);
    const double weight = rng_.uniform(0, 1);
    const Pose at = path.at(path.start + Duration{static_cast<int64_t>(weight * static_cast<double>(path.step.us))});
    ASSERT_NEAR(angleBetween(from, at.orientation), weight * shorter, 1e-4);
  }
}

TEST(Path, IsRefusedIfItCannotBeEvaluated) {
  const Path good{{}, Duration::milliseconds(100), {{}, {}}};
  EXPECT_TRUE(good.validate().ok());
  Path one_pose = good, no_step = good, long_step = good, no_rotation = good;
  one_pose.poses.pop_back();
  no_step.step = {};
  long_step.step = Duration::milliseconds(60'001);
  no_rotation.poses[1].orientation = {2, 0, 0, 0};
  for (const Path& bad : {one_pose, no_step, long_step, no_rotation}) EXPECT_FALSE(bad.validate().ok());
}

}  // namespace
}  // namespace foreland::proto
