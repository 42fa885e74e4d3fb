#include "proto/message/wire_pose.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>

namespace foreland::proto {

namespace {

constexpr int64_t kComponentOffset = 32768;
constexpr int kLargestBits = 2;
constexpr Duration kFarthestAhead = Duration::milliseconds(10'000);
constexpr int64_t kMaxStretch = 8;
constexpr int64_t kLargestChange = 1'000'000'000;  // times 10 s in microseconds, still far inside int64

using Triple = std::array<int64_t, 3>;

Triple minus(const Triple& a, const Triple& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }

bool changesLittle(const Triple& a, const Triple& b) {
  const Triple d = minus(a, b);
  return std::all_of(d.begin(), d.end(), [](int64_t v) { return std::llabs(v) <= kLargestChange; });
}

bool isComponent(int64_t v) { return v >= -kComponentOffset && v < kComponentOffset; }

}  // namespace

WirePose toWire(const Pose& pose, const WireQuanta& steps) {
  WirePose out;
  for (int i = 0; i < 3; ++i) out.eye[static_cast<size_t>(i)] = std::llround(pose.eye[i] * steps.per_metre);
  const glm::dquat& q = pose.orientation;
  const std::array<double, 4> c{q.w, q.x, q.y, q.z};
  for (uint8_t i = 1; i < 4; ++i)
    if (std::fabs(c[i]) > std::fabs(c[out.largest])) out.largest = i;
  const double scale = std::copysign(M_SQRT2 * steps.per_root_half, c[out.largest]);
  size_t k = 0;
  for (size_t i = 0; i < 4; ++i) {
    if (i == out.largest) continue;
    // Usable quaternions may be a little too long.
    out.rest[k++] = std::clamp<int64_t>(std::lround(c[i] * scale), -kComponentOffset, kComponentOffset - 1);
  }
  return out;
}

Pose fromWire(const WirePose& pose, const WireQuanta& steps) {
  Pose out;
  for (int i = 0; i < 3; ++i) out.eye[i] = static_cast<double>(pose.eye[static_cast<size_t>(i)]) / steps.per_metre;
  std::array<double, 4> c{};
  double left = 1;
  size_t k = 0;
  for (size_t i = 0; i < 4; ++i) {
    if (i == pose.largest) continue;
    c[i] = static_cast<double>(pose.rest[k++]) / (M_SQRT2 * steps.per_root_half);
    left -= c[i] * c[i];
  }
  c[pose.largest] = std::sqrt(std::max(left, 0.0));
  const double norm = std::sqrt(c[0] * c[0] + c[1] * c[1] + c[2] * c[2] + c[3] * c[3]);
  out.orientation = {c[0] / norm, c[1] / norm, c[2] / norm, c[3] / norm};
  return out;
}

void putPose(const WirePose& pose, ByteWriter& w, uint8_t marks) {
  for (int64_t v : pose.eye) w.putZigzag(v);
  w.put(static_cast<uint8_t>(pose.largest | marks << kLargestBits));
  for (int64_t v : pose.rest) w.put(static_cast<int16_t>(v));
}

MarkedPose getPose(ByteReader& r) {
  MarkedPose m;
  for (int64_t& v : m.pose.eye) v = r.getZigzag();
  const auto byte = r.get<uint8_t>();
  m.pose.largest = byte & ((1 << kLargestBits) - 1);
  m.marks = static_cast<uint8_t>(byte >> kLargestBits);
  for (int64_t& v : m.pose.rest) v = r.get<int16_t>();
  return m;
}

void WirePoses::add(Time time, const WirePose& pose) {
  moments_[2] = moments_[1];
  moments_[1] = moments_[0];
  moments_[0] = {time, pose};
  count_ = std::min(count_ + 1, 3);
}

int64_t WirePoses::timeChange(Time time) const { return (time - last().time).us - (count_ > 1 ? step(0).us : 0); }

int WirePoses::usableOrder(int order, Duration t) const {
  int usable = 0;
  while (usable < order && usable + 1 < count_ && t > Duration{} && t <= kFarthestAhead && step(usable) > Duration{} &&
         t.us / kMaxStretch <= step(usable).us &&
         changesLittle(moments_[usable].pose.eye, moments_[usable + 1].pose.eye))
    ++usable;
  return usable;
}

WirePose WirePoses::expected(int order, Duration t) const {
  const WirePose& x1 = moments_[0].pose;
  WirePose out = x1;
  order = usableOrder(order, t);
  const auto extend = [&](Triple WirePose::*part, int depth) {
    for (size_t i = 0; i < 3 && depth > 0; ++i) {
      const auto at = [&](int k) { return (moments_[k].pose.*part)[i]; };
      const int64_t v1 = (at(0) - at(1)) * t.us / step(0).us;
      const int64_t v2 = depth > 1 ? (at(1) - at(2)) * t.us / step(1).us : v1;
      (out.*part)[i] += v1 + (v1 - v2);
    }
  };
  extend(&WirePose::eye, order);
  int turns = 0;
  while (turns < order && moments_[turns + 1].pose.largest == x1.largest) ++turns;
  extend(&WirePose::rest, turns);
  return out;
}

WirePoses::Step WirePoses::shortestStep(Time time, const WirePose& pose) const {
  Step best;
  int least = std::numeric_limits<int>::max();
  for (int order = 0; order < kOrders; ++order) {
    const WirePose guess = expected(order, time - last().time);
    const bool same = pose.largest == last().pose.largest;
    const Step candidate{order, minus(pose.eye, guess.eye), same ? minus(pose.rest, guess.rest) : Triple{}};
    if (!fitsGroup(candidate.eye) || !fitsGroup(candidate.rest)) continue;
    const int cost = planGroup(candidate.eye, eye_width_).bits + planGroup(candidate.rest, rest_width_).bits +
                     (order == order_ ? 0 : 1);
    if (cost < least) best = candidate, least = cost;
  }
  return best;
}

bool WirePoses::canPutNext(Time time, const WirePose& pose) const {
  const int64_t change = timeChange(time);
  return fitsGroup({&change, 1}) && shortestStep(time, pose).order >= 0;
}

void WirePoses::putNext(Time time, const WirePose& pose, BitWriter& w) {
  const int64_t change = timeChange(time);
  const Step chosen = shortestStep(time, pose);
  w.putGroup({&change, 1}, time_width_);
  putOrder(chosen.order, w);
  w.putGroup(chosen.eye, eye_width_);
  const bool same_largest = pose.largest == last().pose.largest;
  w.put(same_largest ? 0 : 1, 1);
  if (same_largest) return w.putGroup(chosen.rest, rest_width_);
  w.put(pose.largest, 2);
  for (int64_t v : pose.rest) w.put(static_cast<uint64_t>(v + kComponentOffset), 16);
}

// Of the two that were not expected last time: 0 is the lower one.
void WirePoses::putOrder(int order, BitWriter& w) {
  w.put(order == order_ ? 0 : 1, 1);
  if (order != order_) w.put(order == (order_ == 0 ? 1 : 0) ? 0 : 1, 1);
  order_ = order;
}

int WirePoses::getOrder(BitReader& r) {
  if (r.get(1) == 0) return order_;
  const int lower = order_ == 0 ? 1 : 0, higher = order_ == 2 ? 1 : 2;
  return order_ = r.get(1) == 0 ? lower : higher;
}

std::optional<WirePoses::Moment> WirePoses::getNext(BitReader& r) {
  int64_t change = 0;
  r.getGroup({&change, 1}, time_width_);
  const Duration t{(count_ > 1 ? step(0).us : 0) + change};
  WirePose pose = expected(getOrder(r), t);
  Triple difference{};
  r.getGroup(difference, eye_width_);
  for (size_t i = 0; i < 3; ++i) pose.eye[i] += difference[i];
  if (r.get(1) == 0) {
    r.getGroup(difference, rest_width_);
    for (size_t i = 0; i < 3; ++i) pose.rest[i] += difference[i];
  } else {
    pose.largest = static_cast<uint8_t>(r.get(2));
    for (int64_t& v : pose.rest) v = static_cast<int64_t>(r.get(16)) - kComponentOffset;
  }
  if (!std::all_of(pose.rest.begin(), pose.rest.end(), isComponent)) return std::nullopt;
  return Moment{last().time + t, pose};
}

}  // namespace foreland::proto
