// How many bytes of tiles may follow a keyframe so that the next keyframe does not queue behind them: as many as the
// link takes, found out from how much later than the fastest a keyframe arrives. Tiles are sent in the wake of
// keyframes, so a link that is full shows in the very messages that must not be late. One owner.
// Source: IMAGERY, "When"; delays as the signal of congestion as in LEDBAT (RFC 6817).
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>

#include "base/time.h"

namespace foreland::server {

class TilePace {
 public:
  // A keyframe that was sent at `sent` (the server's clock) arrived at `arrived` (the client's).
  void keyframeArrived(Time arrived_client, Time sent);
  // A keyframe has been sent, so long after the last one. At most so many bytes a second may follow it; 0: no limit.
  void keyframeSent(double interval_s, uint32_t max_bytes_per_second);
  // Whether another tile may be sent now. A tile is sent whole, and what it takes too much is missing afterwards.
  bool mayBeSent() const { return credit_ > 0; }
  void sent(size_t bytes);

  // In force; for tests and experiments.
  double bytesPerSecond() const { return bytes_per_second_; }

 private:
  static constexpr size_t kMemory = 64;  // keyframes
  static constexpr double kFirst = 250e3, kLeast = 10e3, kMost = 20e6;
  static constexpr Duration kQueueing = Duration::milliseconds(50), kFree = Duration::milliseconds(15);

  double bytes_per_second_ = kFirst;
  double credit_ = 0;  // bytes
  bool was_used_up_ = false;
  std::deque<int64_t> delays_us_;  // with the offset between the clocks
};

}  // namespace foreland::server
