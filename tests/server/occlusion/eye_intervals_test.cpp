// What was proved of an interval's eyes is kept exactly as long as these are where the eye is expected to be.
#include "server/occlusion/eye_intervals.h"

#include <gtest/gtest.h>

#include "base/rng.h"

namespace foreland::server {
namespace {

EyeOutlook outlookAt(int64_t first, double error_m, const auto& eyeAt) {
  EyeOutlook outlook{Duration::milliseconds(200), first, first + 1, {}, error_m};
  for (int64_t i = first; i < first + 20; ++i) {
    const glm::dvec3 begin = eyeAt(i), end = eyeAt(i + 1);
    outlook.eyes.push_back({begin, end - begin, 1 + error_m});
  }
  return outlook;
}

glm::dvec3 straight(int64_t i) { return {30.0 * static_cast<double>(i), 0, 500}; }

TEST(EyeIntervals, OfAKnownPathNeverChange) {
  EyeIntervals intervals;
  for (uint32_t keyframe = 1; keyframe < 100; ++keyframe) {
    intervals.expect(outlookAt(keyframe, 0, straight), keyframe);
    EXPECT_EQ(intervals.hasChanged(), keyframe == 1);
    EXPECT_FALSE(intervals.isPredicted());
    EXPECT_GE(intervals.firstChangedAfter(keyframe), intervals.end());
    if (keyframe == 1) continue;
    EXPECT_GE(intervals.firstChangedAfter(keyframe - 1), intervals.end() - 1);
  }
}

// Whatever is expected: a proof of keyframe k for interval i holds as long as firstChangedAfter(k) > i, and then the
// eyes of the interval lie in those of that keyframe.
TEST(EyeIntervals, HoldTheEyesOfTheProofsThatHold) {
  const auto seed = static_cast<uint64_t>(testing::UnitTest::GetInstance()->random_seed());
  SCOPED_TRACE(testing::Message() << "seed " << seed);
  Rng rng(seed);
  EyeIntervals intervals;
  struct Proof {
    uint32_t keyframe;
    int64_t interval;
    EyeSweep eyes;
  };
  std::vector<Proof> proofs;
  uint64_t held = 0, lost = 0;
  double bend = 0;
  int64_t first = -3;
  for (uint32_t keyframe = 1; keyframe < 300; ++keyframe) {
    first += rng.below(20) == 0 ? 1 + static_cast<int64_t>(rng.below(4)) : rng.below(8) == 0 ? 0 : 1;
    if (rng.below(4) == 0) bend = rng.uniform(-0.3, 0.3);
    const EyeOutlook outlook = outlookAt(first, rng.below(3) == 0 ? 0.2 : 2, [&](int64_t i) {
      const auto ahead = static_cast<double>(i - first);
      return straight(i) + glm::dvec3(0, bend * ahead * ahead, 0);
    });
    intervals.expect(outlook, keyframe);
    for (const Proof& proof : proofs) {
      if (proof.interval < intervals.first() || proof.interval >= intervals.end()) continue;
      if (intervals.firstChangedAfter(proof.keyframe) <= proof.interval) {
        ++lost;
        continue;
      }
      ++held;
      const EyeSweep& now = outlook.eyes[static_cast<size_t>(proof.interval - first)];
      EXPECT_TRUE(proof.eyes.contains(now)) << "keyframe " << keyframe << " interval " << proof.interval;
    }
    for (int i = 0; i < 3; ++i) {
      const int64_t interval = intervals.first() + static_cast<int64_t>(rng.below(20));
      EXPECT_TRUE(intervals.eyes(interval).contains(outlook.eyes[static_cast<size_t>(interval - first)]));
      proofs.push_back({keyframe, interval, intervals.eyes(interval)});
    }
  }
  EXPECT_GT(held, 200u);
  EXPECT_GT(lost, 200u);
}

TEST(EyeIntervals, AreAllInvalidIfTheLensChanges) {
  EyeIntervals intervals;
  intervals.expect(outlookAt(5, 0, straight), 1);
  intervals.expect(outlookAt(6, 0, straight), 2);
  EXPECT_GT(intervals.firstChangedAfter(1), 20);
  intervals.invalidate(2);
  EXPECT_TRUE(intervals.hasChanged());
  EXPECT_EQ(intervals.firstChangedAfter(1), 6);
  EXPECT_GE(intervals.firstChangedAfter(2), intervals.end());
}

TEST(EyeSweep, HullsHoldTheirParts) {
  const auto seed = static_cast<uint64_t>(testing::UnitTest::GetInstance()->random_seed());
  SCOPED_TRACE(testing::Message() << "seed " << seed);
  Rng rng(seed);
  for (int round = 0; round < 200; ++round) {
    std::vector<EyeSweep> parts;
    glm::dvec3 at(0);
    for (size_t i = 0; i < 1 + rng.below(16); ++i) {
      const glm::dvec3 way(rng.uniform(-20, 40), rng.uniform(-20, 20), rng.uniform(-5, 5));
      parts.push_back({at, way, rng.uniform(0, 3)});
      at += way;
    }
    const EyeSweep hull = hullOf(parts);
    for (const EyeSweep& part : parts) EXPECT_TRUE(hull.contains(part));
  }
}

}  // namespace
}  // namespace foreland::server
