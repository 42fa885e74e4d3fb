// Poses as they travel: whole numbers, the same on both ends, so that a pose can be delta-coded, that is, sent as its
// difference from the pose that both ends expect after the earlier ones.
//
//   eye          in quanta, rounded to nearest
//   orientation  the quaternion (w, x, y, z) without its largest component, whose index is sent instead and whose sign
//                is made positive; the others, in quanta, rounded to nearest
//
// A viewer's own poses are exact to half a millimetre an axis and 8e-5 rad, those of keyframes to 4 mm and 3e-4 rad.
//
// An absolute pose is bytes: three zigzag varints, a byte, of which the upper six bits are marks, three 16-bit
// integers. A delta-coded pose is bits (base/bits.h), with a width of its own for each kind of group, in brackets the
// first one to remember:
//
//   group of 1    [17] what the time since the last pose is more than the one before that, microseconds
//   1 bit         is another pose expected than last time (the first time: than 0)?
//     yes: 1 bit           the lower or the higher one of the other two
//   group of 3    [14] eye less the expected one
//   1 bit         is the largest component another one than in the last pose?
//     no:  group of 3      [10] the other components less the expected ones
//     yes: 2 bits, 3 times 16 bits    its number; the other components plus 32768
//
// Expected is, with t for the time since the last pose x1, s1 for the time between x2 and x1, s2 between x3 and x2:
//   0  x1
//   1  x1 + v1,             v1 = (x1 - x2) t / s1
//   2  x1 + v1 + (v1 - v2), v2 = (x2 - x3) t / s2
// for eye and components alike, in integers, division towards zero, products before quotients. Only if there are as
// many poses, s1 (and s2) are positive, t is more than 0, at most 10 s, and t / 8 at most s1 (and s2), no coordinate of
// the eye changed by more than 10^9 from one to the next, and, for the components, the same one is left out of all:
// else the largest of 0, 1, 2 for which that is so. The sender chooses the shortest.
//
// Plain values; any thread; portable to WebAssembly.
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "base/bits.h"
#include "base/bytes.h"
#include "proto/space/pose.h"

namespace foreland::proto {

struct WirePose {
  std::array<int64_t, 3> eye{};
  uint8_t largest = 0;            // which component of (w, x, y, z) is left out
  std::array<int64_t, 3> rest{};  // the others in order, -32768 to 32767
  bool operator==(const WirePose&) const = default;
};

// Quanta to a metre, and to a component of 1 / sqrt(2), which is the most that one beside the largest can be.
struct WireQuanta {
  double per_metre, per_root_half;
};
inline constexpr WireQuanta kPoseQuanta{1000, 32767}, kKeyframeQuanta{128, 8191};

// The pose is usable (isUsable).
WirePose toWire(const Pose& pose, const WireQuanta& steps);
// Any numbers give an orientation; the eye may be too far away to be usable.
Pose fromWire(const WirePose& pose, const WireQuanta& steps);

// An absolute pose, and with it `marks`, six bits that say more about it.
void putPose(const WirePose& pose, ByteWriter& w, uint8_t marks = 0);
struct MarkedPose {
  WirePose pose;
  uint8_t marks = 0;
};
MarkedPose getPose(ByteReader& r);

// The poses so far, of which the last three count. Either end of a connection has one for each kind of message that
// carries poses; both add the same poses in the same order, absolute ones and delta-coded ones.
class WirePoses {
 public:
  struct Moment {
    Time time;
    WirePose pose;
  };

  bool empty() const { return count_ == 0; }
  const Moment& last() const { return moments_[0]; }
  void add(Time time, const WirePose& pose);

  // Whether the pose can be delta-coded; if not, it must be sent as an absolute one. There must be a pose before it.
  bool canPutNext(Time time, const WirePose& pose) const;
  // Writes a delta-coded pose, for which canPutNext() is true; does not add it to the memory.
  void putNext(Time time, const WirePose& pose, BitWriter& w);
  // Reads a delta-coded pose; nullopt if the bits are none, which they also are when `r` has run out. Does not add it.
  std::optional<Moment> getNext(BitReader& r);

 private:
  static constexpr int kOrders = 3;
  struct Step {
    int order = -1;  // what is expected; none: the difference is too large
    std::array<int64_t, 3> eye{}, rest{};
  };

  Duration step(int i) const { return moments_[i].time - moments_[i + 1].time; }
  // How much longer it is to `time` than it was before.
  int64_t timeChange(Time time) const;
  WirePose expected(int order, Duration t) const;
  int usableOrder(int order, Duration t) const;
  Step shortestStep(Time time, const WirePose& pose) const;
  void putOrder(int order, BitWriter& w);
  int getOrder(BitReader& r);

  std::array<Moment, 3> moments_;  // newest first
  int count_ = 0;
  int order_ = 0;  // expected last time
  // Initially the widths that suit the second pose of a flight, which is coded against a camera at rest.
  GroupWidth time_width_{17}, eye_width_{14}, rest_width_{10};
};

}  // namespace foreland::proto
