// How slow a link is, from the recent past: the slowest time that a message took, but for outages. What was held up for
// seconds (a sleeping laptop, a tab in the background, a tunnel) says nothing about the messages after it.
// Pure; any thread; portable to WebAssembly.
#pragma once

#include <algorithm>

#include "base/time.h"

namespace foreland {

// Beyond the fastest of the recent past.
inline constexpr Duration kLongestDelay = Duration::seconds(2);

// `latencies` is not empty; they may share an unknown offset. The largest within kLongestDelay of the smallest.
template <class Latencies>
Duration slowestUsual(const Latencies& latencies) {
  const Duration least = *std::min_element(latencies.begin(), latencies.end());
  Duration most = least;
  for (const Duration latency : latencies)
    if (latency <= least + kLongestDelay) most = std::max(most, latency);
  return most;
}

}  // namespace foreland
