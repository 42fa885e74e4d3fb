// A simulated link with its own seed: latency, jitter, rate and stalls, one direction. Messages arrive whole and in
// order, as over a WebSocket. All in virtual time; the same seed gives the same arrivals.
#pragma once

#include <algorithm>
#include <deque>
#include <optional>

#include "base/bytes.h"
#include "base/rng.h"
#include "base/time.h"

namespace foreland::test {

struct LinkOptions {
  Duration latency = Duration::milliseconds(20);
  Duration jitter;              // added uniformly up to this
  double bytes_per_second = 0;  // 0: no limit
  Duration stall_every, stall;  // from time to time nothing moves for a while; 0: never
  // Once nothing is read for a while. What is on its way waits for the reader, in buffers that take everything (the
  // sender gets rid of it), or nothing (a message begun meanwhile leaves when it is read).
  Time pause_begin{}, pause_end{};
  enum class Buffers : uint8_t { kEndless, kNone } buffers = Buffers::kEndless;
};

class Link {
 public:
  Link(const LinkOptions& options, uint64_t seed) : options_(options), rng_(seed) {}

  void send(Bytes message, Time now) {
    const Time begin = std::max(now, sent_);
    const double seconds =
        options_.bytes_per_second > 0 ? static_cast<double>(message.size()) / options_.bytes_per_second : 0;
    sent_ = afterStalls(begin + Duration::seconds(seconds));
    if (options_.buffers == LinkOptions::Buffers::kNone) sent_ = afterPause(sent_);
    const Duration jitter{options_.jitter.us > 0 ? static_cast<int64_t>(rng_.below(options_.jitter.us)) : 0};
    last_arrival_ = afterPause(std::max(last_arrival_, sent_ + options_.latency + jitter));
    on_the_way_.push_back({last_arrival_, sent_, std::move(message)});
  }
  // When everything handed over has left the sender.
  Time drainedAt() const { return sent_; }
  std::optional<Time> nextArrival() const {
    return on_the_way_.empty() ? std::nullopt : std::optional(on_the_way_.front().arrival);
  }
  Bytes receive() {
    Bytes message = std::move(on_the_way_.front().message);
    on_the_way_.pop_front();
    return message;
  }
  // Of messages that have not wholly left the sender.
  size_t unsentBytes(Time now) const {
    size_t sum = 0;
    for (const Message& m : on_the_way_) sum += m.sent > now ? m.message.size() : 0;
    return sum;
  }

 private:
  struct Message {
    Time arrival, sent;
    Bytes message;
  };
  Time afterPause(Time t) const { return t >= options_.pause_begin && t < options_.pause_end ? options_.pause_end : t; }
  Time afterStalls(Time t) const {
    if (options_.stall.us == 0) return t;
    const int64_t into = t.us % options_.stall_every.us;
    return into < options_.stall.us ? t + Duration{options_.stall.us - into} : t;
  }

  LinkOptions options_;
  Rng rng_;
  Time sent_, last_arrival_;
  std::deque<Message> on_the_way_;
};

}  // namespace foreland::test
