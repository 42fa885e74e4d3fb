// What was proved of an interval's eyes is kept as long as these are where the eye is expected to be, and no longer.
#include "server/occlusion/proofs/path_spans.h"

#include <gtest/gtest.h>

#include "base/rng.h"
#include "tests/support/seed.h"

namespace foreland::server {
namespace {

PredictedEyePath eyePathAt(int64_t first, double error_m, const auto& eyeAt) {
  PredictedEyePath eye_path{Duration::milliseconds(200), first, first + 1, {}, error_m};
  for (int64_t i = first; i < first + 22; ++i) {
    const glm::dvec3 begin = eyeAt(i), end = eyeAt(i + 1);
    eye_path.eyes.push_back({begin, end - begin, 1 + error_m});
  }
  return eye_path;
}

glm::dvec3 straight(int64_t i) { return {30.0 * static_cast<double>(i), 0, 500}; }

// PathSpans that are asked for all that they have, as many as there are.
struct Asked {
  PathSpans::Shape shape = PathSpans::kLasting;
  EyeIntervals intervals{};
  PathSpans spans{intervals, nullptr, shape};

  void expect(const PredictedEyePath& eye_path, uint32_t keyframe) {
    intervals.expect(eye_path);
    spans.revise(keyframe);
    for (size_t length = 0; length < PathSpans::kLengths; ++length)
      for (int64_t i = intervals.first(); i < intervals.end(); ++i) spans.at(length, i);
  }
};

class Spans : public testing::TestWithParam<PathSpans::Shape> {};
INSTANTIATE_TEST_SUITE_P(Shapes, Spans, testing::Values(PathSpans::kLasting, PathSpans::kTight));

constexpr PathSpans::Lengths kAll = (1u << PathSpans::kLengths) - 1;

TEST_P(Spans, OfAKnownPathNeverChange) {
  Asked asked{.shape = GetParam()};
  uint32_t revision = 0;
  for (uint32_t keyframe = 1; keyframe < 100; ++keyframe) {
    asked.expect(eyePathAt(keyframe, 0, straight), keyframe);
    if (keyframe == 1) revision = asked.spans.revision();
    EXPECT_EQ(asked.spans.revision(), revision);
    EXPECT_FALSE(asked.intervals.isPredicted());
    EXPECT_GE(asked.spans.firstChangedAfter(1, kAll), asked.intervals.end());
  }
}

// Predictions that differ a little from keyframe to keyframe change nothing; one that differs much does.
TEST(PathSpans, HaveRoomForPredictionsThatChange) {
  Asked asked;
  const auto wobbling = [](uint32_t keyframe) {
    return [keyframe](int64_t i) { return straight(i) + glm::dvec3(0, keyframe % 2 == 0 ? 0.7 : 0, 0); };
  };
  for (uint32_t keyframe = 1; keyframe < 100; ++keyframe) {
    asked.expect(eyePathAt(keyframe, 1, wobbling(keyframe)), keyframe);
    EXPECT_GE(asked.spans.firstChangedAfter(1, kAll), asked.intervals.end());
  }
  const auto elsewhere = [](int64_t i) { return straight(i) + glm::dvec3(0, 0, 40); };
  const uint32_t revision = asked.spans.revision();
  asked.expect(eyePathAt(100, 1, elsewhere), 100);
  EXPECT_LE(asked.spans.firstChangedAfter(99, kAll), asked.intervals.first());
  EXPECT_GE(asked.spans.firstChangedAfter(100, kAll), asked.intervals.end());
  EXPECT_GT(asked.spans.revision(), revision);
}

struct Proof {
  uint32_t keyframe;
  int64_t interval;
  size_t length;
  EyeCapsule eyes;
  uint32_t revision;  // when it last held for all intervals shown
};

// Whatever is expected: a proof of keyframe k for interval i holds as long as firstChangedAfter(k) > i, and then the
// eyes of the interval lie in those of that keyframe. When it ceases to hold for intervals that are shown, the revision
// says so.
TEST_P(Spans, HoldTheEyesOfTheProofsThatHold) {
  const uint64_t seed = test::randomSeed();
  SCOPED_TRACE(seed);
  Rng rng(seed);
  Asked asked{.shape = GetParam()};
  const auto& [shape, intervals, spans] = asked;
  std::vector<Proof> proofs;
  uint64_t held = 0, lost = 0;
  double bend = 0;
  int64_t first = -3;
  for (uint32_t keyframe = 1; keyframe < 300; ++keyframe) {
    first += rng.below(20) == 0 ? 1 + static_cast<int64_t>(rng.below(4)) : rng.below(8) == 0 ? 0 : 1;
    if (rng.below(4) == 0) bend = rng.uniform(-0.02, 0.02);
    const PredictedEyePath eye_path = eyePathAt(first, rng.below(3) == 0 ? 0.2 : 2, [&](int64_t i) {
      const auto ahead = static_cast<double>(i - first);
      return straight(i) + glm::dvec3(0, bend * ahead * ahead, 0);
    });
    asked.expect(eye_path, keyframe);
    for (Proof& proof : proofs) {
      if (proof.interval < intervals.first() || proof.interval >= intervals.end()) continue;
      const int64_t changed = spans.firstChangedAfter(proof.keyframe, static_cast<uint8_t>(1u << proof.length));
      if (changed > intervals.last()) {
        proof.revision = spans.revision();
      } else {
        EXPECT_GT(spans.revision(), proof.revision) << keyframe << " " << proof.interval;
      }
      if (changed <= proof.interval) {
        ++lost;
        continue;
      }
      ++held;
      const EyeCapsule& now = eye_path.eyes[static_cast<size_t>(proof.interval - first)];
      EXPECT_TRUE(proof.eyes.contains(now)) << "keyframe " << keyframe << " interval " << proof.interval;
    }
    for (int i = 0; i < 3; ++i) {
      const size_t length = rng.below(PathSpans::kLengths);
      const int64_t interval = intervals.first() + static_cast<int64_t>(rng.below(20));
      const PathSpan* const span = asked.spans.at(length, interval);
      if (!span) continue;
      EXPECT_TRUE(span->eyes.contains(eye_path.eyes[static_cast<size_t>(interval - first)]));
      proofs.push_back({keyframe, interval, length, span->eyes, spans.revision()});
    }
  }
  EXPECT_GT(held, 200u);
  EXPECT_GT(lost, 100u);
}

// However many intervals a keyframe is shown for. What there is no room for is not proved at all.
TEST_P(Spans, ForgetNoProofThatCeasesToHold) {
  for (const int64_t shown : {1, 2, 20, 40, 41, 50, 100, 101, 130, 400, 3000})
    for (const double error_m : {0.0, 1.0}) {
      Asked asked{.shape = GetParam()};
      const auto& [shape, intervals, spans] = asked;
      const auto eyePathOver = [&](int64_t first, const glm::dvec3& offset) {
        PredictedEyePath eye_path{Duration::milliseconds(20), first, first + shown - 1, {}, error_m};
        for (int64_t i = first; i < first + shown + 20; ++i)
          eye_path.eyes.push_back({straight(i) + offset, straight(i + 1) - straight(i), 1 + error_m});
        return eye_path;
      };
      asked.expect(eyePathOver(7, {}), 1);
      struct Proved {
        int64_t interval;
        PathSpans::Lengths length;
      };
      std::vector<Proved> proved;
      for (int64_t i = intervals.first(); i < intervals.end(); ++i)
        for (size_t length = 0; length < PathSpans::kLengths; ++length)
          if (asked.spans.at(length, i)) proved.push_back({i, static_cast<PathSpans::Lengths>(1u << length)});
      EXPECT_GE(proved.size(), 8u) << shown;
      asked.expect(eyePathOver(8, {0, 0, 90}), 2);
      for (const Proved& p : proved)
        EXPECT_LE(spans.firstChangedAfter(1, p.length), std::max(p.interval, intervals.first()))
            << shown << " intervals, interval " << p.interval;
    }
}

// A span is for far more eyes than are expected by now, and nobody asks for it before the eyes are elsewhere.
TEST(PathSpans, HoldTheEyesOfProofsThatAreNotAskedForAgain) {
  EyeIntervals intervals;
  PathSpans spans(intervals, nullptr, PathSpans::kLasting);
  const auto revise = [&](uint32_t keyframe, double radius_m, const glm::dvec3& offset) {
    PredictedEyePath eye_path = eyePathAt(16, 0, [&](int64_t i) { return straight(i) + offset; });
    for (EyeCapsule& eyes : eye_path.eyes) eyes.radius_m = radius_m;
    intervals.expect(eye_path);
    spans.revise(keyframe);
  };
  revise(1, 60, {});
  ASSERT_NE(spans.at(1, 16), nullptr);
  revise(2, 1, {});
  EXPECT_GE(spans.firstChangedAfter(1, kAll), intervals.end());
  revise(3, 1, {0, 0, 90});
  EXPECT_EQ(spans.firstChangedAfter(1, kAll), 16);
}

TEST(PathSpans, ProveNothingMoreOnceTheyAreInvalid) {
  Asked asked;
  asked.expect(eyePathAt(5, 0, straight), 1);
  asked.expect(eyePathAt(6, 0, straight), 2);
  EXPECT_GT(asked.spans.firstChangedAfter(1, kAll), 20);
  const uint32_t revision = asked.spans.revision();
  asked.spans.invalidate(2);
  EXPECT_GT(asked.spans.revision(), revision);
  EXPECT_EQ(asked.spans.firstChangedAfter(1, kAll), 6);
  EXPECT_GE(asked.spans.firstChangedAfter(2, kAll), asked.intervals.end());
}

// Times that mean other intervals, or go back, leave nothing of what was proved.
TEST(PathSpans, AreOfOneClock) {
  Asked asked;
  asked.expect(eyePathAt(50, 0, straight), 1);
  asked.expect(eyePathAt(49, 0, straight), 2);
  EXPECT_EQ(asked.spans.firstChangedAfter(1, kAll), 49);
  PredictedEyePath slower = eyePathAt(49, 0, straight);
  slower.interval = Duration::milliseconds(300);
  asked.expect(slower, 3);
  EXPECT_EQ(asked.spans.firstChangedAfter(2, kAll), 49);
}

TEST(EyeCapsule, HullsHoldTheirParts) {
  const uint64_t seed = test::randomSeed();
  SCOPED_TRACE(seed);
  Rng rng(seed);
  for (int round = 0; round < 200; ++round) {
    std::vector<EyeCapsule> parts;
    glm::dvec3 at(0);
    for (size_t i = 0; i < 1 + rng.below(16); ++i) {
      const glm::dvec3 way(rng.uniform(-20, 40), rng.uniform(-20, 20), rng.uniform(-5, 5));
      parts.push_back({at, way, rng.uniform(0, 3)});
      at += way;
    }
    const EyeCapsule hull = hullOf(parts);
    for (const EyeCapsule& part : parts) EXPECT_TRUE(hull.contains(part));
  }
}

}  // namespace
}  // namespace foreland::server
