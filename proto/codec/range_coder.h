// Adaptive binary range coding: each yes or no is coded with the probability that its context has learnt, so a likely
// answer costs a small part of a bit. The arithmetic is LZMA's (32-bit range, carries propagated through a cache); a
// probability is the mean of a fast and a slow estimate, of 15 bits each. The decoder takes any bytes: past the end it
// reads zeros, and overrun() tells. One owner each; no allocation but the output's.
#pragma once

#include <cstdint>

#include "base/bytes.h"

namespace foreland::proto {

// What a context has learnt: the probability of `true` in 1/32768.
struct AdaptiveBit {
  uint16_t fast = 1 << 14;
  uint16_t slow = 1 << 14;

  // Kept away from certainty, so that whatever happens costs 1/89 bit at least, and 7 at most.
  uint32_t probability() const {
    const uint32_t p = (uint32_t{fast} + slow) >> 1;
    return p < kMin ? kMin : p > 32768 - kMin ? 32768 - kMin : p;
  }
  void learn(bool value) {
    if (value)
      fast += (32768 - fast) >> 4, slow += (32768 - slow) >> 7;
    else
      fast -= fast >> 4, slow -= slow >> 7;
  }
  static constexpr uint32_t kMin = 256;
};

class RangeEncoder {
 public:
  explicit RangeEncoder(Bytes& out) : out_(out), start_(out.size()) {}

  bool code(AdaptiveBit& bit, bool value) {
    const uint32_t bound = (range_ >> 15) * bit.probability();
    if (value)
      range_ = bound;
    else
      low_ += bound, range_ -= bound;
    bit.learn(value);
    while (range_ < (1u << 24)) shift();
    return value;
  }
  // `count` bits (at most 16) of equal chances.
  uint32_t codeEvenly(uint32_t value, int count) {
    range_ >>= count;
    low_ += uint64_t{range_} * value;
    while (range_ < (1u << 24)) shift();
    return value;
  }
  // The shortest bytes that decode to what was coded; nothing may follow.
  void finish();

  // Bits so far, to the fraction.
  double bits() const;

 private:
  void shift();

  Bytes& out_;
  size_t start_;
  uint64_t low_ = 0;
  uint32_t range_ = 0xffffffffu;
  uint64_t pending_ = 0;  // bytes held back: `cache_`, then 0xff
  uint8_t cache_ = 0;
  bool first_ = true;  // the first byte is always 0 and not written
};

class RangeDecoder {
 public:
  explicit RangeDecoder(ByteSpan bytes) : bytes_(bytes) {
    for (int i = 0; i < 4; ++i) code_ = code_ << 8 | next();
  }

  bool code(AdaptiveBit& bit, bool = false) {
    const uint32_t bound = (range_ >> 15) * bit.probability();
    const bool value = code_ < bound;
    if (value)
      range_ = bound;
    else
      code_ -= bound, range_ -= bound;
    bit.learn(value);
    if (range_ < (1u << 24)) readByte();  // a decision takes 7 bits at most
    return value;
  }
  uint32_t codeEvenly(uint32_t, int count) {
    range_ >>= count;
    uint32_t value = code_ / range_;
    if (value >> count != 0) value = (1u << count) - 1;  // hostile bytes only
    code_ -= value * range_;
    while (range_ < (1u << 24)) readByte();
    return value;
  }

  // More was read than an encoder leaves out.
  bool overrun() const { return at_ > bytes_.size() + kSlack; }
  bool atEnd() const { return at_ >= bytes_.size() && !overrun(); }
  static constexpr size_t kSlack = 4;

 private:
  void readByte() {
    code_ = code_ << 8 | next();
    range_ <<= 8;
  }
  uint8_t next() { return at_ < bytes_.size() ? bytes_[at_++] : (++at_, uint8_t{0}); }

  ByteSpan bytes_;
  size_t at_ = 0;
  uint32_t code_ = 0;
  uint32_t range_ = 0xffffffffu;
};

}  // namespace foreland::proto
