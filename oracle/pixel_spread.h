// Quantiles of any number of pixel distances in bounded memory: they are counted by their leading bits, so a quantile
// is too large by at most a 4096th of itself. One owner; 8 MB.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace foreland::oracle {

class PixelSpread {
 public:
  // Not negative.
  void add(double px) {
    ++counts_[(std::bit_cast<uint32_t>(static_cast<float>(px)) >> kDropped) % counts_.size()];
    ++count_;
  }
  // `q` from 0 (the least) to 1 (the largest); 0 if there are none.
  double quantile(double q) const {
    if (count_ == 0) return 0;
    const auto before = static_cast<uint64_t>(q * static_cast<double>(count_ - 1));
    uint32_t bucket = 0;
    for (uint64_t passed = counts_[0]; passed <= before; passed += counts_[bucket]) ++bucket;
    return bucket == 0 ? 0 : static_cast<double>(std::bit_cast<float>(((bucket + 1) << kDropped) - 1));
  }

 private:
  static constexpr int kDropped = 11;  // of 23 bits after the leading one
  std::vector<uint64_t> counts_ = std::vector<uint64_t>(size_t{1} << (31 - kDropped));
  uint64_t count_ = 0;
};

}  // namespace foreland::oracle
