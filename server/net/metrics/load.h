// How busy the workers are, and so how much of them a viewer may take: nothing is rationed while there is enough for
// all. Any thread.
#pragma once

#include <atomic>

#include "base/time.h"
#include "server/section/budget.h"

namespace foreland::server {

class Load {
 public:
  static constexpr Duration kWindow = Duration::milliseconds(500);
  static constexpr double kBusy = 0.85, kFree = 0.7;  // shares of the workers' time

  explicit Load(size_t workers) : workers_(static_cast<double>(workers)) {}

  // Notes that a worker was busy for `spent` until `now`.
  void add(Duration spent, Time now);

  // The share of the workers' time that was used in the last whole window.
  double busy() const { return busy_.load(std::memory_order_relaxed); }
  // Whether that was too much, and not long ago.
  bool isOverloaded(Time now) const {
    return busy() > kBusy && now.us < window_end_us_.load(std::memory_order_relaxed) + kWindow.us;
  }

  // What a viewer gets that takes `cost` of one worker's time while `viewers` fly.
  Processors processorsFor(double cost, int64_t viewers) const;
  // Of one worker's time, for each of `viewers`.
  double fairShare(int64_t viewers) const;

 private:
  const double workers_;
  std::atomic<int64_t> window_end_us_{0}, spent_us_{0};
  std::atomic<double> busy_{0};
};

}  // namespace foreland::server
