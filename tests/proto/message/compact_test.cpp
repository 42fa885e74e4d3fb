// Poses and keyframes told by their difference from the last ones: what goes in comes out, it is small, and any other
// bytes end in an Error.
#include <gtest/gtest.h>

#include <bit>

#include "base/rng.h"
#include "proto/message/message.h"

namespace foreland::proto {
namespace {

// A viewer's camera that flies at some 200 m/s and looks about as a hand on a mouse does, at `interval` with `jitter`.
class Flight {
 public:
  Flight(uint64_t seed, Duration interval, Duration jitter) : rng_(seed), interval_(interval), jitter_(jitter) {}

  TimedPose next() {
    if (++count_ % 40 == 1) acceleration_ = {rng_.uniform(-20, 20), rng_.uniform(-20, 20), rng_.uniform(-10, 10)};
    if (count_ % 15 == 1) spin_ = {rng_.uniform(-0.8, 0.8), rng_.uniform(-0.8, 0.8), 0};
    const Time now = Time{} + interval_ * count_ +
                     Duration{static_cast<int64_t>(rng_.below(2 * static_cast<uint64_t>(jitter_.us) + 1)) - jitter_.us};
    const double dt = (now - last_.time).toSeconds();
    velocity_ += acceleration_ * dt;
    turn_ += (spin_ - turn_) * 0.3;
    last_.time = now;
    last_.pose.eye += velocity_ * dt;
    last_.pose.orientation = glm::normalize(last_.pose.orientation * glm::dquat(1, turn_ * (0.5 * dt)));
    return last_;
  }

 private:
  Rng rng_;
  Duration interval_, jitter_;
  int64_t count_ = 0;
  TimedPose last_;
  glm::dvec3 velocity_{200, 0, 0}, acceleration_{0}, spin_{0}, turn_{0};
};

void expectSamePose(const Pose& got, const Pose& expected) {
  EXPECT_EQ(got.eye, expected.eye);
  EXPECT_EQ(got.orientation, expected.orientation);
}

TEST(PoseUpdates, ArriveAsIfEachWereAbsolute) {
  const uint64_t seed = testing::UnitTest::GetInstance()->random_seed();
  Rng rng(seed);
  Flight flight(seed, Duration::milliseconds(50), Duration::milliseconds(8));
  PoseMemory sent_before, taken_before;
  uint32_t received = 0;
  Time received_at;
  for (int i = 0; i < 5000; ++i) {
    PoseUpdate sent{flight.next(), received, received_at};
    if (rng.below(50) == 0) sent.pose.pose.eye.x += rng.uniform(-1e7, 1e7);
    sent.has_jumped = rng.below(50) == 0;
    if (rng.below(4) == 0) {
      received += static_cast<uint32_t>(rng.below(100) == 0 ? rng.below(1u << 30) : 1 + rng.below(3) / 2);
      received_at = sent.pose.time - Duration{static_cast<int64_t>(rng.below(80'000))};
      sent.received_keyframe = received;
      sent.received_at = received_at;
    }
    const Bytes bytes = encode(sent, sent_before);
    const auto message = decodeClientMessage(bytes, taken_before);
    ASSERT_TRUE(message.ok()) << message.error().message << "; seed " << seed << ", pose " << i;
    const auto& got = std::get<PoseUpdate>(*message);
    EXPECT_EQ(got.pose.time, sent.pose.time);
    expectSamePose(got.pose.pose, asSent(sent.pose.pose));
    EXPECT_EQ(got.has_jumped, sent.has_jumped);
    EXPECT_EQ(got.received_keyframe, sent.received_keyframe);
    EXPECT_GE(got.received_at, sent.received_at);
    EXPECT_LE(got.received_at, sent.received_at + Duration{256});
  }
}

// Who knows of no jumps has written zeros where the mark is, and what else may be marked one day is not looked at.
TEST(PoseUpdates, ThatAnnounceAJumpDifferByOneBit) {
  Flight flight(11, Duration::milliseconds(50), {});
  PoseUpdate update{flight.next(), 3, {}};
  Bytes moved = encode(update);
  update.has_jumped = true;
  const Bytes jumped = encode(update);
  ASSERT_EQ(moved.size(), jumped.size());
  size_t mark = 0;
  for (size_t i = 0; i < moved.size(); ++i)
    if (moved[i] != jumped[i]) mark = i;
  moved[mark] ^= 4;
  EXPECT_EQ(moved, jumped);
  moved[mark] = static_cast<uint8_t>(moved[mark] & 3) | 0xf8;
  const auto other = decodeClientMessage(moved);
  ASSERT_TRUE(other.ok());
  EXPECT_FALSE(std::get<PoseUpdate>(*other).has_jumped);
  expectSamePose(std::get<PoseUpdate>(*other).pose.pose, asSent(update.pose.pose));
}

TEST(PoseUpdates, TakeAtMost16BytesAfterTheFirst) {
  for (const Duration jitter : {Duration{}, Duration::milliseconds(2), Duration::milliseconds(10)}) {
    Flight flight(6, Duration::milliseconds(50), jitter);
    PoseMemory memory;
    size_t largest = 0, sum = 0;
    constexpr int kPoses = 4000;
    const size_t first = encode(PoseUpdate{flight.next(), 0, {}}, memory).size();
    EXPECT_LE(first, 32u);
    for (int i = 0; i < kPoses; ++i) {
      PoseUpdate update{flight.next(), static_cast<uint32_t>(i / 4), {}};
      update.received_at = update.pose.time - Duration{1000 * (17 + 50 * (i % 4))};
      const size_t size = encode(update, memory).size();
      largest = std::max(largest, size);
      sum += size;
    }
    EXPECT_LE(largest, 16u) << jitter.toMilliseconds();
    EXPECT_LE(static_cast<double>(sum) / kPoses, 10) << jitter.toMilliseconds();
  }
}

KeyframeHeader headerFor(const TimedPose& pose, const KeyframeHeader& last, Rng& rng) {
  KeyframeHeader h{last.index + 1, last.index, pose.time, pose.pose, last.lens, last.tau_px, 0, 0, 0};
  h.region_radius_m = shortAtLeast(rng.uniform(40, 41));
  h.region_angle_rad = shortAtLeast(rng.uniform(0.1, 0.11));
  h.fingerprint = static_cast<uint32_t>(rng.next());
  return h;
}

void expectSameHeader(const KeyframeHeader& got, const KeyframeHeader& sent) {
  EXPECT_EQ(got.index, sent.index);
  EXPECT_EQ(got.base_index, sent.base_index);
  EXPECT_EQ(got.time, sent.time);
  expectSamePose(got.pose, asSentInHeader(sent.pose));
  EXPECT_EQ(got.lens, sent.lens);
  EXPECT_EQ(std::bit_cast<uint32_t>(got.tau_px), std::bit_cast<uint32_t>(sent.tau_px));
  EXPECT_EQ(std::bit_cast<uint32_t>(got.region_radius_m), std::bit_cast<uint32_t>(sent.region_radius_m));
  EXPECT_EQ(std::bit_cast<uint32_t>(got.region_angle_rad), std::bit_cast<uint32_t>(sent.region_angle_rad));
  EXPECT_EQ(got.fingerprint, sent.fingerprint & got.fingerprint_mask);
}

TEST(KeyframeHeaders, ArriveAsIfEachWereAbsolute) {
  const uint64_t seed = testing::UnitTest::GetInstance()->random_seed();
  Rng rng(seed);
  Flight flight(seed, Duration::milliseconds(200), {});
  KeyframeMemory sent_before, taken_before;
  KeyframeHeader last;
  uint32_t told = 0, index_before = 0;
  int in_a_row = 0;
  for (int i = 0; i < 5000; ++i) {
    KeyframeHeader sent = headerFor(flight.next(), last, rng);
    if (rng.below(20) == 0) sent.tau_px = static_cast<float>(rng.uniform(0.1, 9));
    if (rng.below(20) == 0) sent.lens = {rng.uniform(0.1, 2.9), static_cast<uint32_t>(1 + rng.below(16384)), 270};
    if (rng.below(20) == 0) sent.region_radius_m = static_cast<float>(rng.uniform(0, 1e6));
    if (rng.below(20) == 0) sent.region_angle_rad = 0;
    if (rng.below(20) == 0) sent.pose.eye.y += rng.uniform(-1e7, 1e7);
    if (rng.below(20) == 0) sent.index += static_cast<uint32_t>(rng.below(100'000));
    if (rng.below(20) == 0) sent.base_index -= static_cast<uint32_t>(rng.below(sent.base_index + 1));
    if (rng.below(20) == 0) sent.time = sent.time + Duration{static_cast<int64_t>(rng.below(20'000'000'000))};
    last = sent;
    Bytes bytes;
    encodeHeader(sent, sent_before, bytes);
    const size_t header_bytes = bytes.size();
    for (uint64_t k = rng.below(3); k > 0; --k) bytes.push_back(static_cast<uint8_t>(rng.next()));
    const auto message = decodeServerMessage(bytes, taken_before);
    ASSERT_TRUE(message.ok()) << message.error().message << "; seed " << seed << ", keyframe " << i;
    const auto& got = std::get<KeyframeMessage>(*message);
    expectSameHeader(got.header, sent);
    const bool is_next = sent.index == index_before + 1;
    told = (is_next && in_a_row < 4 ? told : 0) | got.header.fingerprint_mask;
    in_a_row = is_next && in_a_row < 4 ? in_a_row + 1 : 1;
    if (in_a_row == 4) { EXPECT_EQ(told, 0xffffffffu) << "four keyframes in a row tell all of it"; }
    index_before = sent.index;
    EXPECT_EQ(got.delta.data(), bytes.data() + header_bytes);
    EXPECT_EQ(got.delta.size(), bytes.size() - header_bytes);
  }
}

TEST(KeyframeHeaders, TakeAQuarterOfTheFirst) {
  Rng rng(8);
  Flight flight(8, Duration::milliseconds(200), {});
  KeyframeMemory memory;
  KeyframeHeader last;
  size_t sum = 0, first = 0;
  for (int i = 0; i < 1000; ++i) {
    Bytes bytes;
    last = headerFor(flight.next(), last, rng);
    encodeHeader(last, memory, bytes);
    (i == 0 ? first : sum) += bytes.size();
  }
  EXPECT_GE(first, 40u);
  EXPECT_LE(static_cast<double>(sum) / 999, 12);
}

TEST(CompactMessages, FollowNothingOnAFreshConnection) {
  Flight flight(9, Duration::milliseconds(50), {});
  PoseMemory memory;
  const Bytes first = encode(PoseUpdate{flight.next(), 0, {}}, memory),
              second = encode(PoseUpdate{flight.next(), 0, {}}, memory);
  EXPECT_TRUE(decodeClientMessage(first).ok());
  EXPECT_FALSE(decodeClientMessage(second).ok());
  KeyframeMemory keyframes;
  Bytes one, two;
  encodeHeader({1, 0, {}, flight.next().pose, {}, 1, 0, 0, 5}, keyframes, one);
  encodeHeader({2, 1, {}, flight.next().pose, {}, 1, 0, 0, 6}, keyframes, two);
  EXPECT_TRUE(decodeServerMessage(one).ok());
  EXPECT_FALSE(decodeServerMessage(two).ok());
}

TEST(CompactMessages, CutShortOrTooLongEndInAnError) {
  Flight flight(10, Duration::milliseconds(50), {});
  PoseMemory sent, taken;
  KeyframeMemory keyframes_sent, keyframes_taken;
  ASSERT_TRUE(decodeClientMessage(encode(PoseUpdate{flight.next(), 0, {}}, sent), taken).ok());
  Bytes whole;
  encodeHeader({1, 0, {}, flight.next().pose, {}, 1, 0, 0, 5}, keyframes_sent, whole);
  ASSERT_TRUE(decodeServerMessage(whole, keyframes_taken).ok());
  Bytes pose = encode(PoseUpdate{flight.next(), 0, {}}, sent), header;
  encodeHeader({2, 1, {}, flight.next().pose, {}, 1, 0, 0, 6}, keyframes_sent, header);
  const auto poseIsTaken = [&](ByteSpan bytes) {
    PoseMemory memory = taken;
    return decodeClientMessage(bytes, memory).ok();
  };
  const auto headerIsTaken = [&](ByteSpan bytes) {
    KeyframeMemory memory = keyframes_taken;
    return decodeServerMessage(bytes, memory).ok();
  };
  EXPECT_TRUE(poseIsTaken(pose) && headerIsTaken(header));
  for (size_t n = 0; n < pose.size(); ++n) EXPECT_FALSE(poseIsTaken(ByteSpan(pose).first(n))) << n;
  for (size_t n = 0; n < header.size(); ++n) EXPECT_FALSE(headerIsTaken(ByteSpan(header).first(n))) << n;
  pose.push_back(0);
  EXPECT_FALSE(poseIsTaken(pose));
}

// Some bytes that are meant well, then spoilt; or none that are.
Bytes spoilt(Bytes bytes, Rng& rng) {
  if (rng.below(3) == 0) bytes.resize(1 + rng.below(24));
  for (uint64_t k = 1 + rng.below(4); k > 0; --k)
    bytes[rng.below(bytes.size())] ^= static_cast<uint8_t>(1u << rng.below(8));
  if (rng.below(4) == 0)
    for (uint8_t& byte : bytes) byte = static_cast<uint8_t>(rng.next());
  return bytes;
}

TEST(CompactMessages, AnyBytesEndInAPoseThatCanBeSaidAgainOrInAnError) {
  const uint64_t seed = testing::UnitTest::GetInstance()->random_seed();
  Rng rng(seed);
  Flight flight(seed, Duration::milliseconds(50), Duration::milliseconds(2));
  PoseMemory memory;
  size_t accepted = 0;
  for (int i = 0; i < 50'000; ++i) {
    if (i % 50 == 0) memory = {};
    PoseMemory sent = memory, taken = memory, said = memory, heard = memory;
    const Bytes good = encode(PoseUpdate{flight.next(), static_cast<uint32_t>(i), {}}, sent);
    const auto m = decodeClientMessage(i % 50 == 0 ? good : spoilt(good, rng), taken);
    if (!m || !std::holds_alternative<PoseUpdate>(*m)) continue;
    const auto& pose = std::get<PoseUpdate>(*m);
    EXPECT_TRUE(isUsable(pose.pose.pose));
    EXPECT_TRUE(decodeClientMessage(encode(pose, said), heard).ok()) << "seed " << seed;
    memory = taken;
    ++accepted;
  }
  EXPECT_GT(accepted, 10'000u) << "only good bytes test the rest";
  EXPECT_LT(accepted, 49'000u);
}

TEST(CompactMessages, AnyBytesEndInAKeyframeThatCanBeSaidAgainOrInAnError) {
  const uint64_t seed = testing::UnitTest::GetInstance()->random_seed();
  Rng rng(seed);
  Flight flight(seed, Duration::milliseconds(200), {});
  KeyframeMemory memory;
  size_t accepted = 0;
  for (int i = 0; i < 50'000; ++i) {
    if (i % 50 == 0) memory = {};
    KeyframeMemory sent = memory, taken = memory, said = memory, heard = memory;
    Bytes good;
    encodeHeader(headerFor(flight.next(), memory.last, rng), sent, good);
    if (i % 50 != 0) good = spoilt(good, rng);
    const auto m = decodeServerMessage(good, taken);
    if (!m || !std::holds_alternative<KeyframeMessage>(*m)) continue;
    const KeyframeHeader& h = std::get<KeyframeMessage>(*m).header;
    EXPECT_TRUE(isUsable(h.pose) && isUsable(h.lens) && h.tau_px > 0 && h.base_index < h.index);
    EXPECT_TRUE(std::isfinite(h.tau_px) && std::isfinite(h.region_radius_m) && std::isfinite(h.region_angle_rad));
    Bytes again;
    encodeHeader(h, said, again);
    EXPECT_TRUE(decodeServerMessage(again, heard).ok()) << "seed " << seed;
    memory = taken;
    ++accepted;
  }
  EXPECT_GT(accepted, 10'000u) << "only good bytes test the rest";
  EXPECT_LT(accepted, 49'000u);
}

TEST(ShortAtLeast, IsNoSmallerAndLittleLarger) {
  Rng rng(12);
  for (int i = 0; i < 10000; ++i) {
    const double value = std::exp(rng.uniform(-20, 20));
    const float rounded = shortAtLeast(value);
    EXPECT_GE(static_cast<double>(rounded), value);
    EXPECT_LE(static_cast<double>(rounded), value * (1 + 1.0 / 128));
    EXPECT_EQ(std::bit_cast<uint32_t>(rounded) & 0xffff, 0u);
    EXPECT_EQ(shortAtLeast(static_cast<double>(rounded)), rounded);
  }
  EXPECT_EQ(shortAtLeast(0), 0.0f);
}

}  // namespace
}  // namespace foreland::proto
