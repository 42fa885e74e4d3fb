// How many bytes of tiles may follow a keyframe so that the next keyframe hardly queues behind them. Tiles are sent in
// the wake of keyframes and arrive in order, so the acknowledgement of a keyframe tells how long it queued behind the
// tiles before it, and that they have arrived. The rate rises while keyframes arrive as fast as ever, and falls when
// they queue. It begins with a guess, within what the first keyframe tells of the link; until that one has arrived, not
// more than one interval's share is sent. Where the link's queue is the transport's own, keyframes do not queue but are
// computed later, once all has been sent (Session::onDrained): then the time that takes tells the link's rate, and
// tiles get what keyframes leave of it. One owner. Source: THEORY section 5, "When"; delays as the signal of a queue as
// in LEDBAT (RFC 6817).
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <optional>

#include "base/time.h"

namespace foreland::server {

class TilePace {
 public:
  // A keyframe of so many bytes leaves, and the next one after an interval. At most so many bytes of tiles a second may
  // follow; 0: no limit.
  void keyframeSent(uint32_t index, size_t bytes, Time now, double interval_s, uint32_t max_bytes_per_second);
  // It arrived at this time of the client's clock; it and the answer took `round_trip`.
  void keyframeArrived(uint32_t index, Time arrived_client, Duration round_trip);
  // The keyframe and the tiles that follow it are given to the transport, and have been sent by it.
  void given(Time now);
  void drained(Time now);
  // Whether another tile may be sent now. A tile is sent whole, and what it takes too much is missing afterwards.
  bool mayBeSent() const { return credit_ > 0; }
  void sent(size_t bytes);

  // In force; for tests and experiments.
  double bytesPerSecond() const { return bytes_per_second_; }

 private:
  struct Sent {
    uint32_t index;
    Time at;
    double own_bytes;
    double bytes;   // of tiles, before it
    bool is_tried;  // more tiles waited than could be sent
  };
  double bytes_per_second_ = 250e3;
  double credit_ = 0;                // bytes
  double sent_ = 0, delivered_ = 0;  // bytes of tiles
  std::deque<Sent> under_way_;       // keyframes
  std::optional<Time> batch_at_;     // when the last keyframe was given to the transport, until that has sent it
  double batch_bytes_ = 0;           // of it, and of the tiles that followed
  std::optional<double> link_;       // bytes a second that the transport sends, once that is known; at least
  std::optional<double> min_us_;     // delay, with the offset between the clocks
  bool is_measured_ = false;         // a keyframe has arrived
  bool was_full_ = false;            // keyframes have queued
};

}  // namespace foreland::server
