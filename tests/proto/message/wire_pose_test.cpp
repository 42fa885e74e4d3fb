// Poses told by their difference: what goes in comes out, and the bits are what the header says.
#include "proto/message/wire_pose.h"

#include <gtest/gtest.h>

#include "base/rng.h"

namespace foreland::proto {
namespace {

Pose somePose(Rng& rng) {
  const glm::dquat q(rng.uniform(-1, 1), rng.uniform(-1, 1), rng.uniform(-1, 1), rng.uniform(-1, 1));
  return {{rng.uniform(-1e6, 1e6), rng.uniform(-1e6, 1e6), rng.uniform(-1e4, 1e4)}, glm::normalize(q)};
}

// A camera that mostly moves on, and now and then stands, jumps, turns about, or has a clock that does.
class Camera {
 public:
  explicit Camera(uint64_t seed) : rng_(seed), pose_(somePose(rng_)) {}
  WirePoses::Moment next() {
    const uint64_t what = rng_.below(12);
    time_ = time_ + Duration{static_cast<int64_t>(what == 0 ? 0 : rng_.below(what == 1 ? 40'000'000 : 70'000))};
    if (what == 2) time_ = time_ - Duration{static_cast<int64_t>(rng_.below(1'000'000))};
    if (what == 3) pose_ = somePose(rng_);
    if (what == 4) velocity_ = {rng_.uniform(-300, 300), rng_.uniform(-300, 300), rng_.uniform(-30, 30)};
    if (what > 4) pose_.eye += velocity_ * 0.05;
    const glm::dvec3 axis(rng_.uniform(-1, 1), rng_.uniform(-1, 1), rng_.uniform(-1, 1));
    if (what > 7) pose_.orientation = glm::normalize(glm::dquat(1, axis * rng_.uniform(0, 0.2)) * pose_.orientation);
    return {time_, toWire(pose_, kPoseQuanta)};
  }

 private:
  Rng rng_;
  Pose pose_;
  Time time_;
  glm::dvec3 velocity_{0};
};

// Reads one pose after another as the header describes it, bit by bit.
class Reader {
 public:
  WirePoses::Moment read(const Bytes& bytes, const std::vector<WirePoses::Moment>& x) {  // newest last
    bytes_ = &bytes;
    at_ = 0;
    const size_t n = x.size();
    const auto gap = [&](size_t i) { return x[n - i].time.us - x[n - i - 1].time.us; };  // s1, s2
    const int64_t t = (n > 1 ? gap(1) : 0) + group(1, time_width_)[0];
    if (bits(1) == 1) {
      const std::array<std::array<int, 2>, 3> others{{{1, 2}, {0, 2}, {0, 1}}};
      order_ = others[static_cast<size_t>(order_)][static_cast<size_t>(bits(1))];
    }
    WirePose pose = x[n - 1].pose;
    size_t depth = 0;
    while (depth < static_cast<size_t>(order_) && depth + 1 < n && t > 0 && t <= 10'000'000 && gap(depth + 1) > 0 &&
           t / 8 <= gap(depth + 1) && isNear(x[n - 1 - depth].pose.eye, x[n - 2 - depth].pose.eye))
      ++depth;
    const auto eye = group(3, eye_width_);
    for (size_t i = 0; i < 3; ++i)
      pose.eye[i] = guess(depth, t, gap, [&](size_t k) { return x[n - k].pose.eye[i]; }) + eye[i];
    if (bits(1) == 0) {
      size_t same = 0;
      while (same < depth && x[n - 2 - same].pose.largest == pose.largest) ++same;
      const auto rest = group(3, rest_width_);
      for (size_t i = 0; i < 3; ++i)
        pose.rest[i] = guess(same, t, gap, [&](size_t k) { return x[n - k].pose.rest[i]; }) + rest[i];
    } else {
      pose.largest = static_cast<uint8_t>(bits(2));
      for (int64_t& v : pose.rest) v = bits(16) - 32768;
    }
    return {x[n - 1].time + Duration{t}, pose};
  }

 private:
  static bool isNear(const std::array<int64_t, 3>& a, const std::array<int64_t, 3>& b) {
    for (size_t i = 0; i < 3; ++i)
      if (a[i] - b[i] > 1'000'000'000 || b[i] - a[i] > 1'000'000'000) return false;
    return true;
  }
  template <class Gap, class At>
  static int64_t guess(size_t depth, int64_t t, const Gap& gap, const At& x) {
    if (depth == 0) return x(1);
    const int64_t v1 = (x(1) - x(2)) * t / gap(1);
    if (depth == 1) return x(1) + v1;
    const int64_t v2 = (x(2) - x(3)) * t / gap(2);
    return x(1) + v1 + (v1 - v2);
  }
  int64_t bits(int width) {
    int64_t value = 0;
    for (int i = 0; i < width; ++i, ++at_) value |= int64_t{(*bytes_)[at_ / 8] >> (at_ % 8) & 1} << i;
    return value;
  }
  std::array<int64_t, 3> group(int count, int& width) {
    if (bits(1) == 1) {
      if (bits(1) == 1)
        width = static_cast<int>(bits(5));
      else
        width += bits(1) == 1 ? -1 : 1;
    }
    std::array<int64_t, 3> values{};
    for (int i = 0; i < count; ++i) {
      const int64_t code = bits(width);
      values[static_cast<size_t>(i)] = code % 2 == 0 ? code / 2 : -(code + 1) / 2;
    }
    return values;
  }

  const Bytes* bytes_ = nullptr;
  size_t at_ = 0;
  int order_ = 0, time_width_ = 17, eye_width_ = 14, rest_width_ = 10;
};

TEST(WirePoses, WhatGoesInComesOutAndIsAsWritten) {
  const uint64_t seed = testing::UnitTest::GetInstance()->random_seed();
  for (uint64_t flight = 0; flight < 20; ++flight) {
    Camera camera(seed + flight);
    WirePoses sent, taken;
    Reader as_written;
    std::vector<WirePoses::Moment> all;
    size_t alone = 0;
    for (int i = 0; i < 2000; ++i) {
      const auto moment = camera.next();
      Bytes bytes;
      BitWriter w(bytes);
      const bool follows = !sent.empty() && sent.canPutNext(moment.time, moment.pose);
      if (follows) {
        sent.putNext(moment.time, moment.pose, w);
        w.finish();
        BitReader r(bytes);
        const auto got = taken.getNext(r);
        EXPECT_TRUE(r.finish().empty() && r.ok());
        ASSERT_TRUE(got.has_value()) << "seed " << seed << ", pose " << i;
        EXPECT_EQ(got->time, moment.time) << "seed " << seed << ", pose " << i;
        EXPECT_EQ(got->pose, moment.pose) << "seed " << seed << ", pose " << i;
        const auto read = as_written.read(bytes, all);
        EXPECT_EQ(read.time, moment.time) << "seed " << seed << ", pose " << i;
        EXPECT_EQ(read.pose, moment.pose) << "seed " << seed << ", pose " << i;
      }
      alone += !follows;
      sent.add(moment.time, moment.pose);
      taken.add(moment.time, moment.pose);
      all.push_back(moment);
    }
    EXPECT_LT(alone, 400u) << "jumps of more than 1000 km are rare here";
  }
}

TEST(WirePoses, SteadyMotionCostsNextToNothing) {
  WirePoses poses;
  const glm::dquat level(1, 0, 0, 0);
  for (int i = 0; i < 100; ++i) {
    const WirePose pose = toWire({{12.5 * i, -3.0 * i, 0.25 * i * i}, level}, kPoseQuanta);
    Bytes bytes;
    BitWriter w(bytes);
    if (i > 0) {
      ASSERT_TRUE(poses.canPutNext(Time{50'000 * i}, pose));
      poses.putNext(Time{50'000 * i}, pose, w);
      w.finish();
      EXPECT_LE(bytes.size(), i > 4 ? 2u : 16u) << i;
    }
    poses.add(Time{50'000 * i}, pose);
  }
}

TEST(WirePose, AnyNumbersMakeAnOrientation) {
  Rng rng(4);
  for (int i = 0; i < 2000; ++i) {
    WirePose pose;
    pose.largest = static_cast<uint8_t>(rng.below(4));
    for (int64_t& v : pose.rest) v = static_cast<int64_t>(rng.below(65536)) - 32768;
    EXPECT_TRUE(isUsable(fromWire(pose, kPoseQuanta)));
    pose.eye[rng.below(3)] = 100'000'000'001;
    EXPECT_FALSE(isUsable(fromWire(pose, kPoseQuanta)));
  }
}

TEST(WirePose, IsAsExactAsItsQuantaSay) {
  Rng rng(5);
  const auto angleBetween = [](const Pose& a, const Pose& b) {
    const glm::dquat q = glm::conjugate(a.orientation) * b.orientation;
    return 2 * std::asin(std::min(1.0, std::sqrt(q.x * q.x + q.y * q.y + q.z * q.z)));
  };
  for (int i = 0; i < 20'000; ++i) {
    const Pose pose = somePose(rng), own = fromWire(toWire(pose, kPoseQuanta), kPoseQuanta),
               keyframe = fromWire(toWire(pose, kKeyframeQuanta), kKeyframeQuanta);
    for (int k = 0; k < 3; ++k) {
      EXPECT_LE(std::fabs(own.eye[k] - pose.eye[k]), 0.0005 + 1e-9);
      EXPECT_LE(std::fabs(keyframe.eye[k] - pose.eye[k]), 0.004);
    }
    EXPECT_LE(angleBetween(own, pose), 8e-5);
    EXPECT_LE(angleBetween(keyframe, pose), 3.1e-4);
  }
}

TEST(WirePose, UsablePosesOfAlmostUnitLengthTravelToo) {
  // The components of (1, 1, 0, 0) / sqrt(2), a little too long as isUsable allows, reach the edge of what 16 bits
  // hold.
  const double c = M_SQRT1_2 * std::sqrt(1.0009);
  const Pose pose{{1, 2, 3}, glm::dquat(c, c, 0, 0)};
  ASSERT_TRUE(isUsable(pose));
  const Pose got = fromWire(toWire(pose, kPoseQuanta), kPoseQuanta);
  EXPECT_NEAR(std::fabs(glm::dot(got.orientation, glm::normalize(pose.orientation))), 1, 1e-6);
}

}  // namespace
}  // namespace foreland::proto
