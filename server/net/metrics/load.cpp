#include "server/net/metrics/load.h"

#include <algorithm>
#include <cmath>

#include "base/smoothing.h"

namespace foreland::server {

// One thread closes a window; what others add meanwhile counts to the next one.
void Load::add(Duration spent, Time now) {
  spent_us_.fetch_add(spent.us, std::memory_order_relaxed);
  int64_t end = window_end_us_.load(std::memory_order_relaxed);
  if (now.us < end || !window_end_us_.compare_exchange_strong(end, now.us + kWindow.us, std::memory_order_relaxed))
    return;
  const auto sum = static_cast<double>(spent_us_.exchange(0, std::memory_order_relaxed));
  const int64_t length_us = end == 0 ? kWindow.us : now.us - end + kWindow.us;
  const double used = std::min(1.0, sum / (static_cast<double>(length_us) * workers_));
  busy_.store(used, std::memory_order_relaxed);
  const bool has_waited = has_waited_.exchange(false, std::memory_order_relaxed);
  const bool has_room = used <= kCrowded && !has_waited;
  const double change = has_room ? (used < kIdle ? kQuickRegain : kRegain) : used > kFree ? -1 : -kShed;
  changeOcclusionShare(change);
  constexpr double kUntilKnown_s = 2;
  expected_.store(
      expected_.load(std::memory_order_relaxed) * std::exp(-1e-6 * static_cast<double>(length_us) / kUntilKnown_s),
      std::memory_order_relaxed);
}

int Load::weightPercent(double busy) {
  return static_cast<int>(std::clamp(std::lround(100 * (1 - busy / kBusy)), 1L, 100L));
}

// What two threads change at once may count once.
void Load::changeOcclusionShare(double by) {
  occlusion_share_.store(std::clamp(occlusionShare() + by, 0.0, 1.0), std::memory_order_relaxed);
}

void Load::addViewer() {
  const double expected = expected_.load(std::memory_order_relaxed) + kUsualCost / workers_;
  expected_.store(expected, std::memory_order_relaxed);
  if (busy() + expected > kArrivals) changeOcclusionShare(-kCrowd);
}

void Load::addWait(Duration wait) {
  if (wait > kMaxWait) has_waited_.store(true, std::memory_order_relaxed);
}

double Load::fairShare(int64_t viewers) const {
  return kBusy * workers_ / static_cast<double>(std::max<int64_t>(viewers, 1));
}

double Load::costAfter(double cost, Duration spent, Duration elapsed) {
  const double elapsed_s = std::max(1e-6, elapsed.toSeconds());
  return cost + weightOfNew(elapsed_s, kCostMemory.toSeconds()) * (spent.toSeconds() / elapsed_s - cost);
}

Processors Load::processorsFor(double cost, int64_t viewers) const {
  const double share = busy();
  if (share < kFree) return Processors::kFree;
  return share > kBusy && cost > fairShare(viewers) ? Processors::kScarce : Processors::kTaken;
}

}  // namespace foreland::server
