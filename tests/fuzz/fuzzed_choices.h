// A fuzzer's bytes as the choices that Rng (base/rng.h) makes by its seed: as few bytes each as it takes, so that a
// change of one byte changes one choice. Zeros once the bytes are used up. One owner; the bytes must outlive it.
#pragma once

#include <algorithm>

#include "base/bytes.h"

namespace foreland::test {

class FuzzedChoices {
 public:
  explicit FuzzedChoices(ByteSpan bytes) : bytes_(bytes) {}

  bool isAtEnd() const { return bytes_.empty(); }
  uint64_t next() { return take(8); }
  // In [0, count); count > 0.
  uint64_t below(uint64_t count) {
    size_t size = 1;
    while (size < 8 && count >> (8 * size) != 0) ++size;
    return take(size) % count;
  }
  double uniform(double low, double high) { return low + (high - low) * static_cast<double>(take(2)) * 0x1p-16; }

 private:
  uint64_t take(size_t size) {
    size = std::min(size, bytes_.size());
    uint64_t value = 0;
    for (size_t i = 0; i < size; ++i) value |= uint64_t{bytes_[i]} << (8 * i);
    bytes_ = bytes_.subspan(size);
    return value;
  }

  ByteSpan bytes_;
};

}  // namespace foreland::test
