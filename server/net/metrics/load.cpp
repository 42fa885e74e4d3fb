#include "server/net/metrics/load.h"

#include <algorithm>

namespace foreland::server {

// One thread closes a window; what others add meanwhile counts to the next one.
void Load::add(Duration spent, Time now) {
  spent_us_.fetch_add(spent.us, std::memory_order_relaxed);
  int64_t end = window_end_us_.load(std::memory_order_relaxed);
  if (now.us < end || !window_end_us_.compare_exchange_strong(end, now.us + kWindow.us, std::memory_order_relaxed))
    return;
  const auto sum = static_cast<double>(spent_us_.exchange(0, std::memory_order_relaxed));
  const int64_t length_us = end == 0 ? kWindow.us : now.us - end + kWindow.us;
  busy_.store(std::min(1.0, sum / (static_cast<double>(length_us) * workers_)), std::memory_order_relaxed);
}

double Load::fairShare(int64_t viewers) const {
  return kBusy * workers_ / static_cast<double>(std::max<int64_t>(viewers, 1));
}

Processors Load::processorsFor(double cost, int64_t viewers) const {
  const double share = busy();
  if (share < kFree) return Processors::kFree;
  return share > kBusy && cost > fairShare(viewers) ? Processors::kScarce : Processors::kTaken;
}

}  // namespace foreland::server
