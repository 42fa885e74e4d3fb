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
  // The same, or 0 if nothing was added since.
  double busyAt(Time now) const {
    return now.us < window_end_us_.load(std::memory_order_relaxed) + kWindow.us ? busy() : 0;
  }
  // What is left of kBusy where `busy` is used, as the weight that HAProxy's agent-check takes: 1 to 100 percent.
  static int weightPercent(double busy);

  // Notes a new viewer, who is expected to take kUsualCost until what it takes shows.
  void addViewer();
  static constexpr double kUsualCost = 0.01;  // of a worker: two milliseconds of five keyframes a second

  // Notes that a keyframe waited so long for a worker, from its release.
  void addWait(Duration wait);

  // The share of viewers for whom what is hidden is looked for. Falls by kShed in each window in which more than
  // kCrowded was used, or a keyframe waited longer than kMaxWait, to 0 where more than kFree was used;
  // rises by kRegain in others, by kQuickRegain where less than kIdle was used. Falls by kCrowd with each new viewer
  // with whom more than kArrivals is expected to be used: what many cost who come at once shows only when they have
  // come.
  double occlusionShare() const { return occlusion_share_.load(std::memory_order_relaxed); }
  static constexpr double kCrowded = 0.5, kShed = 0.3, kRegain = 0.01, kQuickRegain = 0.1, kIdle = 0.3, kArrivals = 0.3,
                          kCrowd = 0.1;
  static constexpr Duration kMaxWait = Duration::milliseconds(20);

  // What a viewer gets that takes `cost` of one worker's time while `viewers` fly.
  Processors processorsFor(double cost, int64_t viewers) const;
  // What a viewer takes of one worker's time, smoothed over kCostMemory, that took `cost` until `elapsed` ago and used
  // `spent` since.
  static double costAfter(double cost, Duration spent, Duration elapsed);
  static constexpr Duration kCostMemory = Duration::milliseconds(2000);
  // Of one worker's time, for each of `viewers`.
  double fairShare(int64_t viewers) const;

 private:
  void changeOcclusionShare(double by);

  const double workers_;
  std::atomic<int64_t> window_end_us_{0}, spent_us_{0};
  std::atomic<double> busy_{0}, expected_{0}, occlusion_share_{1};
  std::atomic<bool> has_waited_{false};  // a keyframe, in this window, for longer than kMaxWait
};

}  // namespace foreland::server
