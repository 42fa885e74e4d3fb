// Bounds-checked writing and reading of bits, the least significant bit of a byte first; for messages that are too
// small for whole bytes. Readers accept any bytes: a read past the end yields zero and makes `ok()` false for good.
// Value types, one owner; portable to WebAssembly.
#pragma once

#include <algorithm>
#include <bit>
#include <cstdint>
#include <span>

#include "base/bytes.h"
#include "base/check.h"
#include "base/zigzag.h"

namespace foreland {

// The numbers of a group share one width, so small numbers cost little. The width is coded as the difference from that
// of the last group of the same kind, which both ends remember:
//
//   bit 0              the same width
//   bits 1 0 and s     one bit more (s = 0) or less (s = 1)
//   bits 1 1 and five  the width itself, 0 to 31
//
// Then each number follows in zigzag code (0, -1, 1, -2, ...) of that width. Numbers from -2^30 to 2^30 - 1 fit.
struct GroupWidth {
  int last = 0;
};
inline constexpr int kGroupWidthBits = 5;
inline constexpr int kMaxGroupWidth = (1 << kGroupWidthBits) - 1;
inline constexpr int64_t kGroupLimit = int64_t{1} << (kMaxGroupWidth - 1);

inline bool fitsGroup(std::span<const int64_t> values) {
  return std::all_of(values.begin(), values.end(), [](int64_t v) { return v >= -kGroupLimit && v < kGroupLimit; });
}

// How a group is coded: with the width that its numbers need, or with the last width where that is shorter in all.
struct GroupPlan {
  int width = 0, bits = 0;  // of each number; of the whole group
};
inline GroupPlan planGroup(std::span<const int64_t> values, GroupWidth width) {
  uint64_t all = 0;
  for (int64_t v : values) all |= toZigzag(v);
  const int needed = std::bit_width(all), count = static_cast<int>(values.size());
  const int change = needed - width.last;
  const int header = change == 0 ? 1 : change == 1 || change == -1 ? 3 : 2 + kGroupWidthBits;
  const GroupPlan exact{needed, header + count * needed}, unchanged{width.last, 1 + count * width.last};
  return needed <= width.last && unchanged.bits <= exact.bits ? unchanged : exact;
}

class BitWriter {
 public:
  // Appends to `out`; nothing else may append to it before finish().
  explicit BitWriter(Bytes& out) : out_(out) {}

  // Writes `width` bits, 0 to 32. `value` must fit them.
  void put(uint64_t value, int width) {
    CHECK_EQ(value >> width, 0u);
    pending_ |= value << pending_bits_;
    for (pending_bits_ += width; pending_bits_ >= 8; pending_bits_ -= 8) {
      out_.push_back(static_cast<uint8_t>(pending_));
      pending_ >>= 8;
    }
  }
  // The values must fit (fitsGroup).
  void putGroup(std::span<const int64_t> values, GroupWidth& width) {
    const int wanted = planGroup(values, width).width, change = wanted - width.last;
    if (change == 0) {
      put(0, 1);
    } else if (change == 1 || change == -1) {
      put(0b01, 2);
      put(change < 0 ? 1 : 0, 1);
    } else {
      put(0b11, 2);
      put(static_cast<uint64_t>(wanted), kGroupWidthBits);
    }
    width.last = wanted;
    for (int64_t v : values) put(toZigzag(v), wanted);
  }
  // Fills up the last byte with zeros.
  void finish() { put(0, (8 - pending_bits_) % 8); }

 private:
  Bytes& out_;
  uint64_t pending_ = 0;
  int pending_bits_ = 0;
};

class BitReader {
 public:
  explicit BitReader(ByteSpan bytes) : bytes_(bytes) {}

  bool ok() const { return ok_; }
  // Reads `width` bits, 0 to 32.
  uint64_t get(int width) {
    if (!ok_) return 0;
    for (; pending_bits_ < width; pending_bits_ += 8) {
      if (at_ == bytes_.size()) {
        ok_ = false;
        return 0;
      }
      pending_ |= static_cast<uint64_t>(bytes_[at_++]) << pending_bits_;
    }
    const uint64_t value = pending_ & ((uint64_t{1} << width) - 1);
    pending_ >>= width;
    pending_bits_ -= width;
    return value;
  }
  void getGroup(std::span<int64_t> values, GroupWidth& width) {
    if (get(1) == 1) {
      const bool is_new = get(1) == 1;
      const int code = static_cast<int>(get(is_new ? kGroupWidthBits : 1));
      width.last = is_new ? code : code == 1 ? width.last - 1 : width.last + 1;
    }
    if (width.last < 0 || width.last > kMaxGroupWidth) ok_ = false;
    for (int64_t& v : values) v = ok_ ? fromZigzag(get(width.last)) : 0;
  }
  // The bytes after the last one that bits were read from. Its unread bits must be zero, else `ok()` becomes false.
  ByteSpan finish() {
    if (pending_ != 0) ok_ = false;
    pending_ = 0;
    pending_bits_ = 0;
    return bytes_.subspan(at_);
  }

 private:
  ByteSpan bytes_;
  size_t at_ = 0;
  uint64_t pending_ = 0;
  int pending_bits_ = 0;
  bool ok_ = true;
};

}  // namespace foreland
