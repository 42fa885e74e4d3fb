// What was proved of an interval's eyes is kept as long as these are where the eye is expected to be, and no longer.
#include "server/occlusion/proofs/stretches.h"

#include <gtest/gtest.h>

#include "base/rng.h"
#include "tests/support/seed.h"

namespace foreland::server {
namespace {

EyeOutlook outlookAt(int64_t first, double error_m, const auto& eyeAt) {
  EyeOutlook outlook{Duration::milliseconds(200), first, first + 1, {}, error_m};
  for (int64_t i = first; i < first + 22; ++i) {
    const glm::dvec3 begin = eyeAt(i), end = eyeAt(i + 1);
    outlook.eyes.push_back({begin, end - begin, 1 + error_m});
  }
  return outlook;
}

glm::dvec3 straight(int64_t i) { return {30.0 * static_cast<double>(i), 0, 500}; }

// Stretches that are asked for all that they have, as many as there are.
struct Asked {
  EyeIntervals intervals;
  Stretches stretches{intervals, nullptr};

  void expect(const EyeOutlook& outlook, uint32_t keyframe) {
    intervals.expect(outlook);
    stretches.revise(keyframe);
    for (size_t length = 0; length < Stretches::kLengths; ++length)
      for (int64_t i = intervals.first(); i < intervals.end(); ++i) stretches.at(length, i);
  }
};

constexpr Stretches::Lengths kAll = (1u << Stretches::kLengths) - 1;

TEST(Stretches, OfAKnownPathNeverChange) {
  Asked asked;
  uint32_t revision = 0;
  for (uint32_t keyframe = 1; keyframe < 100; ++keyframe) {
    asked.expect(outlookAt(keyframe, 0, straight), keyframe);
    if (keyframe == 1) revision = asked.stretches.revision();
    EXPECT_EQ(asked.stretches.revision(), revision);
    EXPECT_FALSE(asked.intervals.isPredicted());
    EXPECT_GE(asked.stretches.firstChangedAfter(1, kAll), asked.intervals.end());
  }
}

// Predictions that differ a little from keyframe to keyframe change nothing; one that differs much does.
TEST(Stretches, HaveRoomForPredictionsThatChange) {
  Asked asked;
  const auto wobbling = [](uint32_t keyframe) {
    return [keyframe](int64_t i) { return straight(i) + glm::dvec3(0, keyframe % 2 == 0 ? 0.7 : 0, 0); };
  };
  for (uint32_t keyframe = 1; keyframe < 100; ++keyframe) {
    asked.expect(outlookAt(keyframe, 1, wobbling(keyframe)), keyframe);
    EXPECT_GE(asked.stretches.firstChangedAfter(1, kAll), asked.intervals.end());
  }
  const auto elsewhere = [](int64_t i) { return straight(i) + glm::dvec3(0, 0, 40); };
  const uint32_t revision = asked.stretches.revision();
  asked.expect(outlookAt(100, 1, elsewhere), 100);
  EXPECT_LE(asked.stretches.firstChangedAfter(99, kAll), asked.intervals.first());
  EXPECT_GE(asked.stretches.firstChangedAfter(100, kAll), asked.intervals.end());
  EXPECT_GT(asked.stretches.revision(), revision);
}

struct Proof {
  uint32_t keyframe;
  int64_t interval;
  size_t length;
  EyeSweep eyes;
  uint32_t revision;  // when it last held for all intervals shown
};

// Whatever is expected: a proof of keyframe k for interval i holds as long as firstChangedAfter(k) > i, and then the
// eyes of the interval lie in those of that keyframe. When it ceases to hold for intervals that are shown, the revision
// says so.
TEST(Stretches, HoldTheEyesOfTheProofsThatHold) {
  const uint64_t seed = test::randomSeed();
  SCOPED_TRACE(seed);
  Rng rng(seed);
  Asked asked;
  const auto& [intervals, stretches] = asked;
  std::vector<Proof> proofs;
  uint64_t held = 0, lost = 0;
  double bend = 0;
  int64_t first = -3;
  for (uint32_t keyframe = 1; keyframe < 300; ++keyframe) {
    first += rng.below(20) == 0 ? 1 + static_cast<int64_t>(rng.below(4)) : rng.below(8) == 0 ? 0 : 1;
    if (rng.below(4) == 0) bend = rng.uniform(-0.02, 0.02);
    const EyeOutlook outlook = outlookAt(first, rng.below(3) == 0 ? 0.2 : 2, [&](int64_t i) {
      const auto ahead = static_cast<double>(i - first);
      return straight(i) + glm::dvec3(0, bend * ahead * ahead, 0);
    });
    asked.expect(outlook, keyframe);
    for (Proof& proof : proofs) {
      if (proof.interval < intervals.first() || proof.interval >= intervals.end()) continue;
      const int64_t changed = stretches.firstChangedAfter(proof.keyframe, static_cast<uint8_t>(1u << proof.length));
      if (changed > intervals.last()) {
        proof.revision = stretches.revision();
      } else {
        EXPECT_GT(stretches.revision(), proof.revision) << keyframe << " " << proof.interval;
      }
      if (changed <= proof.interval) {
        ++lost;
        continue;
      }
      ++held;
      const EyeSweep& now = outlook.eyes[static_cast<size_t>(proof.interval - first)];
      EXPECT_TRUE(proof.eyes.contains(now)) << "keyframe " << keyframe << " interval " << proof.interval;
    }
    for (int i = 0; i < 3; ++i) {
      const size_t length = rng.below(Stretches::kLengths);
      const int64_t interval = intervals.first() + static_cast<int64_t>(rng.below(20));
      const Stretch* const stretch = asked.stretches.at(length, interval);
      if (!stretch) continue;
      EXPECT_TRUE(stretch->eyes.contains(outlook.eyes[static_cast<size_t>(interval - first)]));
      proofs.push_back({keyframe, interval, length, stretch->eyes, stretches.revision()});
    }
  }
  EXPECT_GT(held, 200u);
  EXPECT_GT(lost, 100u);
}

// However many intervals a keyframe is shown for. What there is no room for is not proved at all.
TEST(Stretches, ForgetNoProofThatCeasesToHold) {
  for (const int64_t shown : {1, 2, 20, 40, 41, 50, 100, 101, 130, 400, 3000})
    for (const double error_m : {0.0, 1.0}) {
      Asked asked;
      const auto& [intervals, stretches] = asked;
      const auto outlookOver = [&](int64_t first, const glm::dvec3& offset) {
        EyeOutlook outlook{Duration::milliseconds(20), first, first + shown - 1, {}, error_m};
        for (int64_t i = first; i < first + shown + 20; ++i)
          outlook.eyes.push_back({straight(i) + offset, straight(i + 1) - straight(i), 1 + error_m});
        return outlook;
      };
      asked.expect(outlookOver(7, {}), 1);
      struct Proved {
        int64_t interval;
        Stretches::Lengths length;
      };
      std::vector<Proved> proved;
      for (int64_t i = intervals.first(); i < intervals.end(); ++i)
        for (size_t length = 0; length < Stretches::kLengths; ++length)
          if (asked.stretches.at(length, i)) proved.push_back({i, static_cast<Stretches::Lengths>(1u << length)});
      EXPECT_GE(proved.size(), 8u) << shown;
      asked.expect(outlookOver(8, {0, 0, 90}), 2);
      for (const Proved& p : proved)
        EXPECT_LE(stretches.firstChangedAfter(1, p.length), std::max(p.interval, intervals.first()))
            << shown << " intervals, interval " << p.interval;
    }
}

// A stretch is for far more eyes than are expected by now, and nobody asks for it before the eyes are elsewhere.
TEST(Stretches, HoldTheEyesOfProofsThatAreNotAskedForAgain) {
  EyeIntervals intervals;
  Stretches stretches(intervals, nullptr);
  const auto revise = [&](uint32_t keyframe, double radius_m, const glm::dvec3& offset) {
    EyeOutlook outlook = outlookAt(16, 0, [&](int64_t i) { return straight(i) + offset; });
    for (EyeSweep& eyes : outlook.eyes) eyes.radius_m = radius_m;
    intervals.expect(outlook);
    stretches.revise(keyframe);
  };
  revise(1, 60, {});
  ASSERT_NE(stretches.at(1, 16), nullptr);
  revise(2, 1, {});
  EXPECT_GE(stretches.firstChangedAfter(1, kAll), intervals.end());
  revise(3, 1, {0, 0, 90});
  EXPECT_EQ(stretches.firstChangedAfter(1, kAll), 16);
}

TEST(Stretches, ProveNothingMoreOnceTheyAreInvalid) {
  Asked asked;
  asked.expect(outlookAt(5, 0, straight), 1);
  asked.expect(outlookAt(6, 0, straight), 2);
  EXPECT_GT(asked.stretches.firstChangedAfter(1, kAll), 20);
  const uint32_t revision = asked.stretches.revision();
  asked.stretches.invalidate(2);
  EXPECT_GT(asked.stretches.revision(), revision);
  EXPECT_EQ(asked.stretches.firstChangedAfter(1, kAll), 6);
  EXPECT_GE(asked.stretches.firstChangedAfter(2, kAll), asked.intervals.end());
}

// Times that mean other intervals, or go back, leave nothing of what was proved.
TEST(Stretches, AreOfOneClock) {
  Asked asked;
  asked.expect(outlookAt(50, 0, straight), 1);
  asked.expect(outlookAt(49, 0, straight), 2);
  EXPECT_EQ(asked.stretches.firstChangedAfter(1, kAll), 49);
  EyeOutlook slower = outlookAt(49, 0, straight);
  slower.interval = Duration::milliseconds(300);
  asked.expect(slower, 3);
  EXPECT_EQ(asked.stretches.firstChangedAfter(2, kAll), 49);
}

TEST(EyeSweep, HullsHoldTheirParts) {
  const uint64_t seed = test::randomSeed();
  SCOPED_TRACE(seed);
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
