// A simulated link with its own seed, one direction: latency, jitter, a rate or a recorded trace of the rate, a queue,
// losses and stalls. Messages arrive whole and in order, as over a WebSocket: what TCP repeats shows as a delay of this
// message and of those behind it. All in virtual time; the same seed gives the same arrivals. One owner.
#pragma once

#include <deque>
#include <memory>
#include <optional>

#include "base/bytes.h"
#include "base/rng.h"
#include "base/time.h"
#include "sim/link_trace.h"

namespace foreland::sim {

// Says when messages leave and arrive, in place of all that LinkOptions has but pauses: how an experiment tries a link
// of its own. One owner, a world's.
class Carrier {
 public:
  struct Carried {
    Time leaves, arrives;  // the sender; at the receiver. now <= leaves <= arrives
  };
  virtual ~Carrier() = default;
  // Takes the next message of the link with this seed, which is how links of one carrier are told apart. What arrives
  // before the message in front of it waits for that one.
  virtual Carried carry(uint64_t link_seed, size_t bytes, Time now) = 0;
};

struct LinkOptions {
  Duration latency = Duration::milliseconds(20);
  Duration jitter{};                // added uniformly up to this
  double bytes_per_second = 0;      // 0: no limit
  Duration stall_every{}, stall{};  // from time to time nothing moves for a while; 0: never
  // Once nothing is read for a while. What is on its way waits for the reader, in buffers that take everything (the
  // sender gets rid of it), or nothing (a message begun meanwhile leaves when it is read).
  Time pause_begin{}, pause_end{};
  enum class Buffers : uint8_t { kEndless, kNone } buffers = Buffers::kEndless;
  std::shared_ptr<const LinkTrace> trace{};  // in place of a rate; null: none
  size_t queue_bytes = 0;                    // what the network takes off the sender before it can be transmitted
  double loss = 0;                           // share of the packets that must be sent again
  Duration repeat_after{};                   // how long that takes
  std::shared_ptr<Carrier> carrier{};        // in place of all of these; null: none
};

class Link {
 public:
  Link(const LinkOptions& options, uint64_t seed) : options_(options), seed_(seed), rng_(seed) {}

  void send(Bytes message, Time now);
  // When everything handed over has left the sender: has been transmitted, or waits in the network's queue.
  Time drainedAt() const { return drained_; }
  std::optional<Time> nextArrival() const {
    return on_the_way_.empty() ? std::nullopt : std::optional(on_the_way_.front().arrival);
  }
  // Of the message that was handed over last; nothing if it has been received.
  std::optional<Time> newestArrival() const {
    return on_the_way_.empty() ? std::nullopt : std::optional(on_the_way_.back().arrival);
  }
  Bytes receive();
  // Nothing moves from `now` until `end`: what is on its way arrives then, and what is sent meanwhile leaves then.
  void stall(Time now, Time end);
  // What has not wholly left the sender never will.
  void dropUnsent(Time now);
  // Of messages that have not wholly left the sender.
  size_t unsentBytes(Time now) const;

 private:
  struct Message {
    Time arrival, drained;
    Bytes message;
  };
  void carry(Bytes message, Time now);
  Time transmitted(size_t bytes, Time begin);
  Time drained(Time now) const;
  Duration repeats(size_t bytes);
  Time afterPause(Time t) const { return t >= options_.pause_begin && t < options_.pause_end ? options_.pause_end : t; }
  Time afterStalls(Time t) const;

  LinkOptions options_;
  uint64_t seed_;
  Rng rng_;
  Time sent_, drained_, last_arrival_;
  LinkTrace::Position at_;  // in the trace
  std::deque<Message> on_the_way_;
};

}  // namespace foreland::sim
