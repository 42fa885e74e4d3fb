#include "proto/message/compact.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>

#include "proto/message/kind.h"

namespace foreland::proto {

namespace {

constexpr int kAgeBits = 8;                        // ages are in units of 256 us
constexpr int64_t kHorizon_us = int64_t{1} << 60;  // largest time, either way
constexpr uint8_t kJumpMark = 1;                   // of a pose update's pose; servers that know none ignore it

void putKind(MessageKind kind, BitWriter& w) { w.put(static_cast<uint64_t>(kind), kKindBits); }

bool isNear(Time t) { return t.us >= -kHorizon_us && t.us <= kHorizon_us; }

// ---- pose updates

Bytes putAbsolutePose(const PoseUpdate& m, const WirePose& pose) {
  Bytes out;
  ByteWriter w(out);
  w.put(MessageKind::kPose);
  w.putZigzag(m.pose.time.us);
  putPose(pose, w, m.has_jumped ? kJumpMark : 0);
  w.putVarint(m.received_keyframe);
  w.putZigzag((m.received_at - m.pose.time).us);
  return out;
}

std::optional<PoseUpdate> getAbsolutePose(ByteSpan bytes, WirePose& pose) {
  ByteReader r(bytes.subspan(1));
  PoseUpdate m;
  m.pose.time = {r.getZigzag()};
  const MarkedPose marked = getPose(r);
  pose = marked.pose;
  m.has_jumped = (marked.marks & kJumpMark) != 0;
  const uint64_t received = r.getVarint();
  const Duration since{r.getZigzag()};
  if (!r.atEnd() || received > 0xffffffffu || !isNear(m.pose.time) || !isNear(Time{} + since)) return std::nullopt;
  m.received_keyframe = static_cast<uint32_t>(received);
  m.received_at = m.pose.time + since;
  return m;
}

// How long ago the acknowledged keyframe arrived, rounded down, so that it never seems to have arrived earlier.
int64_t ageOf(const PoseUpdate& m) { return (m.pose.time - m.received_at).us >> kAgeBits; }

bool canPutPoseStep(const PoseUpdate& m, const WirePose& pose, const PoseMemory& memory) {
  const int64_t later = int64_t{m.received_keyframe} - memory.received_keyframe, age = ageOf(m);
  return !m.has_jumped && !memory.poses.empty() && later >= 0 && fitsGroup({&later, 1}) && fitsGroup({&age, 1}) &&
         memory.poses.canPutNext(m.pose.time, pose);
}

// canPutPoseStep() holds. The memory keeps the acknowledgement as the other end decodes it.
Bytes putPoseStep(const PoseUpdate& m, const WirePose& pose, PoseMemory& memory) {
  Bytes out;
  BitWriter w(out);
  putKind(MessageKind::kPoseStep, w);
  memory.poses.putNext(m.pose.time, pose, w);
  const int64_t later = int64_t{m.received_keyframe} - memory.received_keyframe, age = ageOf(m);
  w.put(static_cast<uint64_t>(std::min<int64_t>(later, 2)), 2);
  GroupWidth none;
  if (later > 1) w.putGroup({&later, 1}, none);
  if (later > 0) {
    w.putGroup({&age, 1}, memory.age_width);
    memory.received_keyframe = m.received_keyframe;
    memory.received_at = m.pose.time - Duration{age << kAgeBits};
  }
  w.finish();
  return out;
}

std::optional<PoseUpdate> getPoseStep(ByteSpan bytes, PoseMemory& memory, WirePose& pose) {
  if (memory.poses.empty()) return std::nullopt;
  BitReader r(bytes);
  r.get(kKindBits);
  const auto next = memory.poses.getNext(r);
  if (!next || !isNear(next->time)) return std::nullopt;
  pose = next->pose;
  PoseUpdate m{{next->time, {}}, memory.received_keyframe, memory.received_at};
  auto later = static_cast<int64_t>(r.get(2));
  if (later == 3) return std::nullopt;
  GroupWidth none;
  if (later == 2) r.getGroup({&later, 1}, none);
  if (later > 0) {
    int64_t age = 0;
    r.getGroup({&age, 1}, memory.age_width);
    m.received_at = m.pose.time - Duration{age * (1 << kAgeBits)};
  }
  const int64_t received = m.received_keyframe + later;
  if (!r.finish().empty() || !r.ok() || later < 0 || received > 0xffffffff) return std::nullopt;
  m.received_keyframe = static_cast<uint32_t>(received);
  return m;
}

void remember(const PoseUpdate& m, const WirePose& pose, PoseMemory& memory) {
  memory.poses.add(m.pose.time, pose);
  memory.received_keyframe = m.received_keyframe;
  memory.received_at = m.received_at;
}

// ---- keyframes

constexpr uint32_t kLongBits = 0xffff;  // of a float, zero in short ones

uint32_t bitsOf(float value) { return std::bit_cast<uint32_t>(value); }
float floatOf(uint64_t bits) { return std::bit_cast<float>(static_cast<uint32_t>(bits)); }

void putAbsoluteHeader(const KeyframeHeader& h, const WirePose& pose, Bytes& out) {
  ByteWriter w(out);
  w.put(MessageKind::kKeyframe);
  w.putVarint(h.index);
  w.putVarint(h.base_index);
  w.putZigzag(h.time.us);
  putPose(pose, w);
  w.putVarint(h.lens.width_px);
  w.putVarint(h.lens.height_px);
  w.put(h.lens.vertical_fov_rad);
  w.put(h.tau_px);
  w.put(h.region_radius_m);
  w.put(h.region_angle_rad);
  w.put(h.fingerprint);
}

std::optional<KeyframeMessage> getAbsoluteHeader(ByteSpan bytes, WirePose& pose) {
  ByteReader r(bytes.subspan(1));
  KeyframeHeader h;
  const uint64_t index = r.getVarint(), base = r.getVarint();
  if (index > 0xffffffffu || base > 0xffffffffu) return std::nullopt;
  h.index = static_cast<uint32_t>(index);
  h.base_index = static_cast<uint32_t>(base);
  h.time = {r.getZigzag()};
  pose = getPose(r).pose;
  const uint64_t width = r.getVarint(), height = r.getVarint();
  h.lens.width_px = static_cast<uint32_t>(std::min<uint64_t>(width, 0xffffffffu));
  h.lens.height_px = static_cast<uint32_t>(std::min<uint64_t>(height, 0xffffffffu));
  h.lens.vertical_fov_rad = r.get<double>();
  h.tau_px = r.get<float>();
  h.region_radius_m = r.get<float>();
  h.region_angle_rad = r.get<float>();
  h.fingerprint = r.get<uint32_t>();
  if (!r.ok()) return std::nullopt;
  return KeyframeMessage{h, bytes.subspan(bytes.size() - r.remaining())};
}

// Fields that a header has only if they are unusual; a bit each.
constexpr int kExtraBits = 4;
constexpr uint64_t kNewOrder = 1, kNewLens = 2, kNewTau = 4, kLongRegion = 8;

uint64_t extrasOf(const KeyframeHeader& h, const KeyframeHeader& last) {
  const bool is_next = h.index == last.index + 1 && h.base_index == last.index;
  const bool is_long = ((bitsOf(h.region_radius_m) | bitsOf(h.region_angle_rad)) & kLongBits) != 0;
  return (is_next ? 0 : kNewOrder) | (h.lens == last.lens ? 0 : kNewLens) |
         (bitsOf(h.tau_px) == bitsOf(last.tau_px) ? 0 : kNewTau) | (is_long ? kLongRegion : 0);
}

std::array<int64_t, 2> orderOf(const KeyframeHeader& h, const KeyframeHeader& last) {
  return {int64_t{h.index} - last.index, int64_t{h.index} - h.base_index};
}

void putExtras(const KeyframeHeader& h, const KeyframeHeader& last, uint64_t extras, BitWriter& w) {
  GroupWidth none;
  if (extras & kNewOrder) w.putGroup(orderOf(h, last), none);
  if (extras & kNewLens) {
    const auto fov = std::bit_cast<uint64_t>(h.lens.vertical_fov_rad);
    w.put(h.lens.width_px, 16);
    w.put(h.lens.height_px, 16);
    w.put(fov & 0xffffffff, 32);
    w.put(fov >> 32, 32);
  }
  if (extras & kNewTau) w.put(bitsOf(h.tau_px), 32);
  if (extras & kLongRegion) {
    w.put(bitsOf(h.region_radius_m), 32);
    w.put(bitsOf(h.region_angle_rad), 32);
  }
}

// Leaves the fields that do not follow as they are. False if the indices are out of range.
bool getExtras(BitReader& r, uint64_t extras, KeyframeHeader& h) {
  GroupWidth none;
  std::array<int64_t, 2> order{1, 1};
  if (extras & kNewOrder) r.getGroup(order, none);
  const int64_t index = h.index + order[0], base = index - order[1];
  if (index < 0 || index > 0xffffffff || base < 0 || base > 0xffffffff) return false;
  h.index = static_cast<uint32_t>(index);
  h.base_index = static_cast<uint32_t>(base);
  if (extras & kNewLens) {
    h.lens.width_px = static_cast<uint32_t>(r.get(16));
    h.lens.height_px = static_cast<uint32_t>(r.get(16));
    const uint64_t low = r.get(32);
    h.lens.vertical_fov_rad = std::bit_cast<double>(low | r.get(32) << 32);
  }
  if (extras & kNewTau) h.tau_px = floatOf(r.get(32));
  if (extras & kLongRegion) {
    h.region_radius_m = floatOf(r.get(32));
    h.region_angle_rad = floatOf(r.get(32));
  }
  return true;
}

std::array<int64_t, 2> upperHalves(const KeyframeHeader& h) {
  return {bitsOf(h.region_radius_m) >> 16, bitsOf(h.region_angle_rad) >> 16};
}

// Each header carries a quarter of the fingerprint, in turns.
constexpr int kQuarterBits = 8;
constexpr uint32_t kQuarterMask = 0xff;
int quarterBegin(uint32_t index) { return kQuarterBits * static_cast<int>(index % 4); }

void putShortRegion(const KeyframeHeader& h, KeyframeMemory& memory, BitWriter& w) {
  const auto now = upperHalves(h), before = upperHalves(memory.last);
  w.putGroup(std::array{now[0] - before[0], now[1] - before[1]}, memory.region_width);
}

void getShortRegion(BitReader& r, KeyframeMemory& memory, KeyframeHeader& h) {
  const auto before = upperHalves(memory.last);
  std::array<int64_t, 2> change{};
  r.getGroup(change, memory.region_width);
  // Numbers beyond 16 bits are no floats: they become one that isSane() refuses.
  const auto changed = [](int64_t upper) {
    return upper >= 0 && upper <= 0xffff ? floatOf(static_cast<uint64_t>(upper) << 16) : -1.0f;
  };
  h.region_radius_m = changed(before[0] + change[0]);
  h.region_angle_rad = changed(before[1] + change[1]);
}

bool canPutHeaderStep(const KeyframeHeader& h, const WirePose& pose, const KeyframeMemory& memory) {
  return !memory.poses.empty() && fitsGroup(orderOf(h, memory.last)) && memory.poses.canPutNext(h.time, pose);
}

// canPutHeaderStep() holds.
void putHeaderStep(const KeyframeHeader& h, const WirePose& pose, KeyframeMemory& memory, Bytes& out) {
  BitWriter w(out);
  putKind(MessageKind::kKeyframeStep, w);
  const uint64_t extras = extrasOf(h, memory.last);
  w.put(extras == 0 ? 0 : 1, 1);
  if (extras != 0) w.put(extras, kExtraBits);
  memory.poses.putNext(h.time, pose, w);
  putExtras(h, memory.last, extras, w);
  if (!(extras & kLongRegion)) putShortRegion(h, memory, w);
  w.put(h.fingerprint >> quarterBegin(h.index) & kQuarterMask, kQuarterBits);
  w.finish();
}

std::optional<KeyframeMessage> getHeaderStep(ByteSpan bytes, KeyframeMemory& memory, WirePose& pose) {
  if (memory.poses.empty()) return std::nullopt;
  KeyframeHeader h = memory.last;
  BitReader r(bytes);
  r.get(kKindBits);
  const uint64_t extras = r.get(1) == 0 ? 0 : r.get(kExtraBits);
  const auto next = memory.poses.getNext(r);
  if (!next || !getExtras(r, extras, h)) return std::nullopt;
  pose = next->pose;
  h.time = next->time;
  if (!(extras & kLongRegion)) getShortRegion(r, memory, h);
  h.fingerprint = static_cast<uint32_t>(r.get(kQuarterBits)) << quarterBegin(h.index);
  h.fingerprint_mask = kQuarterMask << quarterBegin(h.index);
  const ByteSpan delta = r.finish();
  if (!r.ok()) return std::nullopt;
  return KeyframeMessage{h, delta};
}

bool isSane(const KeyframeHeader& h) {
  constexpr float kMax = 1e9f;
  const auto is_size = [](float v) { return v >= 0 && v <= kMax; };
  return h.base_index < h.index && isUsable(h.pose) && isUsable(h.lens) && is_size(h.tau_px) && h.tau_px > 0 &&
         is_size(h.region_radius_m) && is_size(h.region_angle_rad) && isNear(h.time);
}

}  // namespace

Bytes encode(const Resume& m) {
  Bytes out;
  ByteWriter w(out);
  w.put(MessageKind::kResume);
  w.put(m.scene_id);
  w.putVarint(m.keyframe);
  w.putZigzag(m.time.us);
  w.put(m.fingerprint);
  w.putBytes(m.section);
  return out;
}

Result<Resume> decodeResume(ByteSpan bytes) {
  ByteReader r(bytes.subspan(1));
  Resume m;
  m.scene_id = r.get<uint64_t>();
  const uint64_t keyframe = r.getVarint();
  m.keyframe = static_cast<uint32_t>(keyframe);
  m.time = {r.getZigzag()};
  m.fingerprint = r.get<uint32_t>();
  if (!r.ok() || keyframe == 0 || keyframe > 0x7fffffffu || !isNear(m.time))
    return malformed("the section of a resume message is cut short or absurd");
  const ByteSpan section = bytes.subspan(bytes.size() - r.remaining());
  m.section.assign(section.begin(), section.end());
  return m;
}

Result<PoseUpdate> decodePose(ByteSpan bytes, PoseMemory& memory) {
  WirePose pose;
  auto m = kindOf(bytes) == MessageKind::kPose ? getAbsolutePose(bytes, pose) : getPoseStep(bytes, memory, pose);
  if (m) m->pose.pose = fromWire(pose, kPoseQuanta);
  if (!m || !isUsable(m->pose.pose))
    return malformed("a pose update is cut short, too long or absurd, more than 10^8 m away, or follows none");
  remember(*m, pose, memory);
  return *m;
}

Result<KeyframeMessage> decodeKeyframe(ByteSpan bytes, KeyframeMemory& memory) {
  WirePose pose;
  auto m =
      kindOf(bytes) == MessageKind::kKeyframe ? getAbsoluteHeader(bytes, pose) : getHeaderStep(bytes, memory, pose);
  if (m) m->header.pose = fromWire(pose, kKeyframeQuanta);
  if (!m || !isSane(m->header)) return malformed("a keyframe's header is cut short, absurd, or follows none");
  memory.poses.add(m->header.time, pose);
  memory.last = m->header;
  return *m;
}

Bytes encode(const PoseUpdate& m, PoseMemory& memory) {
  const WirePose pose = toWire(m.pose.pose, kPoseQuanta);
  if (canPutPoseStep(m, pose, memory)) {
    Bytes out = putPoseStep(m, pose, memory);
    memory.poses.add(m.pose.time, pose);
    return out;
  }
  remember(m, pose, memory);
  return putAbsolutePose(m, pose);
}

void encodeHeader(const KeyframeHeader& h, KeyframeMemory& memory, Bytes& out) {
  const WirePose pose = toWire(h.pose, kKeyframeQuanta);
  if (canPutHeaderStep(h, pose, memory))
    putHeaderStep(h, pose, memory, out);
  else
    putAbsoluteHeader(h, pose, out);
  memory.poses.add(h.time, pose);
  memory.last = h;
}

Bytes encode(const PoseUpdate& m) {
  PoseMemory none;
  return encode(m, none);
}

void encodeHeader(const KeyframeHeader& h, Bytes& out) {
  KeyframeMemory none;
  encodeHeader(h, none, out);
}

Pose asSent(const Pose& pose) { return fromWire(toWire(pose, kPoseQuanta), kPoseQuanta); }
Pose asSentInHeader(const Pose& pose) { return fromWire(toWire(pose, kKeyframeQuanta), kKeyframeQuanta); }

float shortAtLeast(double value) {
  float rounded = static_cast<float>(value);
  if (static_cast<double>(rounded) < value) rounded = std::nextafter(rounded, HUGE_VALF);
  const uint32_t bits = bitsOf(rounded);
  return std::bit_cast<float>((bits & kLongBits) != 0 ? (bits | kLongBits) + 1 : bits);
}

}  // namespace foreland::proto
