#include "proto/codec/range_coder.h"

#include <cmath>

namespace foreland::proto {

void RangeEncoder::shift() {
  if (low_ < 0xff000000u || low_ > 0xffffffffu) {
    const uint8_t carry = static_cast<uint8_t>(low_ >> 32);
    if (!first_) out_.push_back(static_cast<uint8_t>(cache_ + carry));
    first_ = false;
    for (; pending_ > 0; --pending_) out_.push_back(static_cast<uint8_t>(0xff + carry));
    cache_ = static_cast<uint8_t>(low_ >> 24);
  } else {
    ++pending_;
  }
  low_ = (low_ & 0x00ffffffu) << 8;
  range_ <<= 8;
}

void RangeEncoder::finish() {
  // Of the numbers that decode alike, the one with the most zeros at its end.
  const uint64_t top = low_ + range_ - 1;
  for (int zeros = 32; zeros > 0; --zeros) {
    const uint64_t v = top >> zeros << zeros;
    if (v < low_) continue;
    low_ = v;
    break;
  }
  for (int i = 0; i < 5; ++i) shift();
  for (size_t i = 0; i < RangeDecoder::kSlack && out_.size() > start_ && out_.back() == 0; ++i) out_.pop_back();
}

double RangeEncoder::bits() const {
  const double bytes = static_cast<double>(out_.size() - start_ + pending_) + (first_ ? 0 : 1);
  return 8 * bytes + 32 - std::log2(static_cast<double>(range_));
}

}  // namespace foreland::proto
