// The usual worst latency of a link, estimated from recent messages: the largest one except for outages. A message that
// was held up for seconds (a sleeping laptop, a tab in the background, a tunnel) says nothing about the messages after
// it. Pure; any thread; portable to WebAssembly.
#pragma once

#include <algorithm>

#include "base/time.h"

namespace foreland {

// A latency larger than the smallest one by more than this counts as an outage.
inline constexpr Duration kLongestDelay = Duration::seconds(2);

// The largest of the latencies that are no outages. `latencies` is not empty; all may share an unknown offset.
template <class Latencies>
Duration slowestUsual(const Latencies& latencies) {
  const Duration least = *std::min_element(latencies.begin(), latencies.end());
  Duration most = least;
  for (const Duration latency : latencies)
    if (latency <= least + kLongestDelay) most = std::max(most, latency);
  return most;
}

}  // namespace foreland
