// How the viewer's clock and the server's relate over the link, from the stamps of ordinary messages: clocks are not
// synchronised, and no message is sent for this. With offset = server clock - client clock and latencies L,
//   a pose arrives:           server time - stamp of the pose            = offset + L_up
//   a keyframe is acknowledged: stamp of its arrival - time of sending   = L_down - offset
// From these follow, without the offset itself, the client's time as its newest poses show it, and the server time at
// which a message must leave to arrive at a given client time. Estimates are of the last kMemory messages. One owner.
#pragma once

#include <cstddef>
#include <deque>
#include <optional>

#include "base/time.h"

namespace foreland::server {

class ClockMap {
 public:
  // False if the client's clock was set anew: a stamp is later than any latency explains, or earlier than the last one.
  // All that was known is forgotten then.
  bool poseArrived(Time stamp_client, Time now);
  void keyframeArrived(Time arrival_client, Time sent);

  // Whether a pose has arrived; what follows needs one.
  bool isKnown() const { return !up_.empty(); }
  // The client's time less the fastest recent L_up.
  Time clientTime(Time now) const { return now - Duration{min_up_}; }
  // The time that a message and its answer take, by the same latencies as clientTime() and sendBy().
  Duration roundTrip() const { return Duration{min_up_ + max_down_}; }
  // The server time at which a message should leave to arrive at `arrival_client`, by the slowest recent L_down that is
  // no outage (slowestUsual in base/latency.h).
  Time sendBy(Time arrival_client) const { return Time{arrival_client.us - max_down_}; }
  // The client's time at which a message that leaves at `sent` arrives, by the same L_down.
  Time arrivalOf(Time sent) const { return Time{sent.us + max_down_}; }

 private:
  static constexpr size_t kMemory = 32;               // messages, each way
  static constexpr int64_t kFirstGuess_us = 150'000;  // of L_up + L_down, until a keyframe has been acknowledged

  static constexpr int64_t kMinStep_us = 2'000'000;  // of a clock that is set anew

  std::optional<Time> last_stamp_;
  std::deque<int64_t> up_;
  std::deque<Duration> down_;
  int64_t min_up_ = 0;
  int64_t max_down_ = 0;
};

}  // namespace foreland::server
