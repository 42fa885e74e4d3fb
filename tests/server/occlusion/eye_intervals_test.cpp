// The law of expected eyes: at every time at which a keyframe is shown, the eye lies in the capsule of that time's
// interval, for however long the keyframe is shown.
#include "server/occlusion/proofs/eye_intervals.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <glm/geometric.hpp>

#include "base/rng.h"
#include "tests/support/seed.h"

namespace foreland::server {
namespace {

constexpr Duration kPoseInterval = Duration::milliseconds(50);

proto::Path winding(Rng& rng, int poses) {
  proto::Path path{Time{0}, kPoseInterval, {}};
  proto::Pose pose;
  for (int i = 0; i < poses; ++i) {
    pose.eye += glm::dvec3(rng.uniform(-9, 9), rng.uniform(-9, 9), rng.uniform(-2, 2));
    path.poses.push_back(pose);
  }
  return path;
}

double distance(const EyeCapsule& capsule, const glm::dvec3& eye) {
  const double length2 = glm::dot(capsule.way, capsule.way);
  const double share = length2 > 0 ? std::clamp(glm::dot(eye - capsule.eye, capsule.way) / length2, 0.0, 1.0) : 0;
  return glm::distance(eye, capsule.eye + share * capsule.way);
}

TEST(EyeIntervalsTest, HoldTheEyeForAsLongAsAKeyframeIsShown) {
  Rng rng(test::randomSeed());
  const proto::Path path = winding(rng, 400);
  const ExpectedMotion motion(path);
  const Duration interval = Duration::milliseconds(20);
  for (const int64_t shown : {1, 2, 19, 20, 21, 39, 40, 41, 50, 100, 333}) {
    const Time begin{interval.us * 7 + 3'000}, end = begin + Duration{interval.us * shown};
    EyeIntervals eyes;
    eyes.expect(eyePathOf(motion, begin, end, interval, 0));
    ASSERT_GE(eyes.end(), eyes.last() + 1) << shown;
    for (Time t = begin; t < end; t = t + Duration{1'700}) {
      const int64_t number = std::min(t.us / interval.us, eyes.last());
      const auto capsules = eyes.eyes(number, number + 1);
      ASSERT_EQ(capsules.size(), 1u) << shown << " intervals, in number " << number;
      ASSERT_LE(distance(capsules.front(), motion.at(t).eye), capsules.front().radius_m + 1e-6) << shown;
      ASSERT_LE(distance(eyes.shownEyes(), motion.at(t).eye), eyes.shownEyes().radius_m + 1e-6) << shown;
    }
  }
}

TEST(EyeIntervalsTest, TakeBoundedMemoryInAStall) {
  Rng rng(test::randomSeed());
  const proto::Path path = winding(rng, 400);
  const ExpectedMotion motion(path);
  const Duration interval = Duration::milliseconds(1);
  EyeIntervals eyes;
  eyes.expect(eyePathOf(motion, Time{0}, Time{19'000'000}, interval, 0));
  EXPECT_EQ(eyes.last() + 1, EyeIntervals::kMaxShown);
  EXPECT_LE(eyes.end(), eyes.last() + 1 + EyeIntervals::kAhead);
  for (Time t{0}; t < Time{19'000'000}; t = t + Duration{7'700})
    ASSERT_LE(distance(eyes.shownEyes(), motion.at(t).eye), eyes.shownEyes().radius_m + 1e-6);
}

}  // namespace
}  // namespace foreland::server
