// Bits: what goes in comes out, in the order that the header names; reading beyond the end is noticed.
#include "base/bits.h"

#include <gtest/gtest.h>

#include <array>
#include <vector>

#include "base/rng.h"
#include "tests/support/seed.h"

namespace foreland {
namespace {

TEST(Bits, FieldsAndGroupsComeBack) {
  const uint64_t seed = test::seedOr(1);
  Rng rng(seed);
  for (int round = 0; round < 500; ++round) {
    Bytes bytes;
    BitWriter w(bytes);
    std::vector<std::pair<uint64_t, int>> fields;
    std::vector<std::array<int64_t, 3>> groups;
    GroupWidth written{static_cast<int>(rng.below(32))}, read = written;
    for (int i = 0; i < 20; ++i) {
      const int width = static_cast<int>(rng.below(33));
      fields.emplace_back(rng.next() & ((uint64_t{1} << width) - 1), width);
      w.put(fields.back().first, width);
      const int64_t limit = int64_t{1} << rng.below(31);
      auto& group = groups.emplace_back();
      for (int64_t& v : group) v = static_cast<int64_t>(rng.below(2 * static_cast<uint64_t>(limit))) - limit;
      ASSERT_TRUE(fitsGroup(group));
      w.putGroup(group, written);
    }
    w.finish();
    bytes.push_back(77);
    BitReader r(bytes);
    for (int i = 0; i < 20; ++i) {
      EXPECT_EQ(r.get(fields[i].second), fields[i].first) << "seed " << seed;
      std::array<int64_t, 3> group{};
      r.getGroup(group, read);
      EXPECT_EQ(group, groups[i]) << "seed " << seed;
    }
    const ByteSpan rest = r.finish();
    ASSERT_TRUE(r.ok());
    ASSERT_EQ(rest.size(), 1u);
    EXPECT_EQ(rest[0], 77);
  }
}

TEST(Bits, TheLowestBitOfAByteIsFirst) {
  Bytes bytes;
  BitWriter w(bytes);
  w.put(1, 1);
  w.put(0b10, 2);
  w.put(0x3f, 7);
  w.finish();
  EXPECT_EQ(bytes, (Bytes{0b11111'101, 0b01}));
}

Bytes groupOf(std::array<int64_t, 3> values, GroupWidth width) {
  Bytes bytes;
  BitWriter w(bytes);
  w.putGroup(values, width);
  w.finish();
  return bytes;
}

TEST(Bits, AGroupTellsHowItsWidthDiffers) {
  const std::array<int64_t, 3> values{0, -1, 2};         // zigzag 0, 1, 4: three bits each
  EXPECT_EQ(groupOf(values, {3}), (Bytes{0x10, 0x02}));  // 0, 000, 100, 001
  EXPECT_EQ(groupOf(values, {2}), (Bytes{0x41, 0x08}));  // 100, ...
  EXPECT_EQ(groupOf(values, {4}), (Bytes{0x45, 0x08}));  // 101, ...
  EXPECT_EQ(groupOf(values, {9}), (Bytes{0x0f, 0x84}));  // 11 11000, ...
}

TEST(Bits, GroupsHoldTheirLimitsAndNoMore) {
  for (int64_t v : {-kGroupLimit, kGroupLimit - 1}) {
    EXPECT_TRUE(fitsGroup({&v, 1}));
    Bytes bytes;
    BitWriter w(bytes);
    GroupWidth written, read;
    w.putGroup({&v, 1}, written);
    w.finish();
    int64_t got = 0;
    BitReader(bytes).getGroup({&got, 1}, read);
    EXPECT_EQ(got, v);
  }
  for (int64_t v : {-kGroupLimit - 1, kGroupLimit}) EXPECT_FALSE(fitsGroup({&v, 1}));
}

TEST(Bits, AWidthThatIsNoneIsNoticed) {
  for (const auto& [last, byte] : {std::pair{0, 0b101}, {31, 0b001}}) {  // one less than 0, one more than 31
    const Bytes bytes{static_cast<uint8_t>(byte), 0, 0, 0, 0};
    BitReader r(bytes);
    GroupWidth width{last};
    int64_t value = 5;
    r.getGroup({&value, 1}, width);
    EXPECT_FALSE(r.ok());
    EXPECT_EQ(value, 0);
  }
}

TEST(Bits, ReadingBeyondTheEndIsNoticedForGood) {
  const Bytes bytes{0xff, 0xff};
  BitReader r(bytes);
  EXPECT_EQ(r.get(15), 0x7fffu);
  EXPECT_EQ(r.get(2), 0u);
  EXPECT_FALSE(r.ok());
  EXPECT_EQ(r.get(1), 0u);
  EXPECT_FALSE(r.ok());
}

TEST(Bits, WhatFillsTheLastByteMustBeZero) {
  const Bytes clean{0b0000'0101}, dirty{0b0001'0101};
  for (const Bytes* bytes : {&clean, &dirty}) {
    BitReader r(*bytes);
    EXPECT_EQ(r.get(4), 0b0101u);
    EXPECT_TRUE(r.finish().empty());
    EXPECT_EQ(r.ok(), bytes == &clean);
  }
}

}  // namespace
}  // namespace foreland
