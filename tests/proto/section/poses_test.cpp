// What a vertex of several poses is at a scene time, against straight lines between dates, and what is no set of poses.
#include "proto/section/poses.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numeric>

#include "base/rng.h"
#include "tests/support/seed.h"

namespace foreland::proto {
namespace {

constexpr GridShape kShape{1, 1, 1, 3, 3};

Epochs anyEpochs(Rng& rng, EpochBlend blend) {
  std::vector<Epoch> epochs;
  Time at{1'000};
  for (int i = 0; i < 7; ++i) {
    at = at + Duration{static_cast<int64_t>(1 + rng.below(100'000))};
    epochs.push_back({at, {}});
  }
  return Epochs::create(kShape, std::move(epochs), blend).value();
}

// Linearly blended, a number that each pose has is at any time on the straight line between the poses' dates.
TEST(Poses, AreMixedByTheirDates) {
  const uint64_t seed = test::randomSeed();
  SCOPED_TRACE(seed);
  Rng rng(seed);
  for (int round = 0; round < 100; ++round) {
    const Epochs epochs = anyEpochs(rng, EpochBlend::kLinear);
    std::vector<uint32_t> of_poses;
    for (uint32_t epoch = 0; epoch < epochs.size(); ++epoch)
      if (rng.below(2) == 0) of_poses.push_back(epoch);
    if (of_poses.size() < 2) continue;
    const PoseBlend poses = PoseBlend::create(epochs, of_poses).value();
    std::vector<glm::ivec3> moves;
    for (size_t k = 1; k < of_poses.size(); ++k) moves.emplace_back(rng.below(1000), rng.below(1000), 7);
    const auto at = [&](size_t pose) {
      return pose == 0 ? glm::dvec3(5) : glm::dvec3(5) + glm::dvec3(moves[pose - 1]);
    };
    for (int i = 0; i < 50; ++i) {
      const Time t = epochs.first() + Duration{static_cast<int64_t>(rng.below(700'000))};
      size_t next = 0;
      while (next < of_poses.size() && epochs[of_poses[next]].time <= t) ++next;
      glm::dvec3 expected = at(next == 0 ? 0 : next - 1);
      if (next > 0 && next < of_poses.size()) {
        const double from = (t - epochs[of_poses[next - 1]].time).toSeconds(),
                     span = (epochs[of_poses[next]].time - epochs[of_poses[next - 1]].time).toSeconds();
        expected += (at(next) - expected) * (from / span);
      }
      const glm::dvec3 got = posed(glm::ivec3(5), moves, poses.weightsAt(epochs.weightsAt(t)));
      for (int axis = 0; axis < 3; ++axis) EXPECT_NEAR(got[axis], expected[axis], 1e-6);
    }
  }
}

TEST(Poses, AreMixedByAWholeAndNeverOvershoot) {
  const uint64_t seed = test::randomSeed();
  SCOPED_TRACE(seed);
  Rng rng(seed);
  const Epochs epochs = anyEpochs(rng, EpochBlend::kBSpline);
  const std::vector<uint32_t> of_poses{1, 2, 5};
  const PoseBlend poses = PoseBlend::create(epochs, of_poses).value();
  for (int i = 0; i < 200; ++i) {
    const Time t = epochs.first() + Duration{static_cast<int64_t>(rng.below(700'000))};
    const std::vector<double> weights = poses.weightsAt(epochs.weightsAt(t));
    ASSERT_EQ(weights.size(), 2u);
    for (const double w : weights) EXPECT_GE(w, 0);
    EXPECT_LE(std::accumulate(weights.begin(), weights.end(), 0.0), 1 + 1e-12);
  }
}

TEST(Poses, AreRefusedWhereTheyFitNoScene) {
  Rng rng(1);
  const Epochs epochs = anyEpochs(rng, EpochBlend::kLinear);
  for (const std::vector<uint32_t>& wrong : {std::vector<uint32_t>{3}, {2, 2}, {3, 1}, {0, 7}})
    EXPECT_FALSE(PoseBlend::create(epochs, wrong).ok());
  const std::vector<uint32_t> fine{0, 3};
  EXPECT_TRUE(PoseBlend::create(epochs, fine).ok());
  EXPECT_FALSE(PoseBlend::create({}, fine).ok());
  const auto overshoots = PoseBlend::create(anyEpochs(rng, EpochBlend::kCatmullRom), fine);
  ASSERT_FALSE(overshoots.ok());
  EXPECT_NE(overshoots.error().message.find("Catmull-Rom"), std::string::npos);
  EXPECT_TRUE(PoseBlend::create({}, {}).value().isStill());
}

}  // namespace
}  // namespace foreland::proto
