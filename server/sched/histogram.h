// Counts of durations in fixed buckets, for Prometheus. Any thread adds and reads; a reader may see a new sample in the
// counts before it sees it in the sum, which a graph does not show.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>

#include "base/time.h"

namespace foreland::server {

class Histogram {
 public:
  // Upper ends of the buckets; one more bucket takes what is longer.
  static constexpr std::array<Duration, 12> kBounds = {
      Duration{100},    Duration{250},    Duration{500},    Duration{1'000},   Duration{2'500},   Duration{5'000},
      Duration{10'000}, Duration{25'000}, Duration{50'000}, Duration{100'000}, Duration{250'000}, Duration{1'000'000}};

  // Negative durations count as zero.
  void add(Duration sample) {
    size_t bucket = 0;
    while (bucket < kBounds.size() && sample > kBounds[bucket]) ++bucket;
    counts_[bucket].fetch_add(1, std::memory_order_relaxed);
    sum_us_.fetch_add(sample.us > 0 ? static_cast<uint64_t>(sample.us) : 0, std::memory_order_relaxed);
  }

  // How many samples bucket `i` alone has; i <= kBounds.size().
  uint64_t count(size_t i) const { return counts_[i].load(std::memory_order_relaxed); }
  Duration sum() const { return {static_cast<int64_t>(sum_us_.load(std::memory_order_relaxed))}; }

 private:
  std::array<std::atomic<uint64_t>, kBounds.size() + 1> counts_{};
  std::atomic<uint64_t> sum_us_{0};
};

}  // namespace foreland::server
