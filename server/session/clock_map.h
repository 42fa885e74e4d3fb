// How the viewer's clock and the server's relate over the link, from what messages tell: no synchronisation, no round
// of its own.
//   pose arrives:  server time - its stamp       = offset + L_up
//   keyframe:      arrival stamp - server time   = L_down - offset   (the client acknowledges with the arrival's stamp)
// So the client's time "now, as far as heard", and the server time by which something must leave to be there at a
// client time, follow without knowing the offset. Estimates keep to the recent past. One owner.
#pragma once

#include <cstddef>
#include <deque>

#include "base/time.h"

namespace foreland::server {

class ClockMap {
 public:
  void poseArrived(Time stamp_client, Time now);
  void keyframeArrived(Time arrival_client, Time sent);

  bool isKnown() const { return !up_.empty(); }
  // The client's time as its newest poses have it: behind the true one by the fastest recent L_up.
  Time clientTime(Time now) const { return now - Duration{least_up_}; }
  // Server time at which a message should leave to arrive at `arrival_client`, by the slowest recent L_down, outages
  // apart.
  Time sendBy(Time arrival_client) const { return Time{arrival_client.us - most_down_}; }

 private:
  static constexpr size_t kMemory = 32;
  static constexpr int64_t kFirstGuess_us = 150'000;  // of L_up + L_down, until a keyframe has been acknowledged

  std::deque<int64_t> up_;
  std::deque<Duration> down_;
  int64_t least_up_ = 0;
  int64_t most_down_ = 0;
};

}  // namespace foreland::server
