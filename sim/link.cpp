#include "sim/link.h"

#include <algorithm>

namespace foreland::sim {

void Link::send(Bytes message, Time now) {
  if (options_.carrier) return carry(std::move(message), now);
  sent_ = transmitted(message.size(), std::max(now, sent_));
  if (options_.buffers == LinkOptions::Buffers::kNone) sent_ = afterPause(sent_);
  drained_ = std::max(drained_, drained(now));
  const Duration jitter{options_.jitter.us > 0 ? static_cast<int64_t>(rng_.below(options_.jitter.us)) : 0};
  const Time arrival = sent_ + options_.latency + jitter + repeats(message.size());
  last_arrival_ = afterPause(std::max(last_arrival_, arrival));
  on_the_way_.push_back({last_arrival_, drained_, std::move(message)});
}

void Link::carry(Bytes message, Time now) {
  const Carrier::Carried carried = options_.carrier->carry(seed_, message.size(), now);
  sent_ = drained_ = std::max(drained_, carried.leaves);
  last_arrival_ = afterPause(std::max(last_arrival_, carried.arrives));
  on_the_way_.push_back({last_arrival_, drained_, std::move(message)});
}

Time Link::transmitted(size_t bytes, Time begin) {
  if (options_.trace) return afterStalls(options_.trace->transmit(bytes, begin, at_));
  const double seconds = options_.bytes_per_second > 0 ? static_cast<double>(bytes) / options_.bytes_per_second : 0;
  return afterStalls(begin + Duration::seconds(seconds));
}

// When what is not transmitted yet fits into the queue. On a trace the mean rate stands for what it will be.
Time Link::drained(Time now) const {
  const double rate = options_.trace ? options_.trace->bytesPerSecond() : options_.bytes_per_second;
  if (options_.queue_bytes == 0 || rate <= 0) return sent_;
  return std::max(now, sent_ - Duration::seconds(static_cast<double>(options_.queue_bytes) / rate));
}

// Each packet may be lost; those of one message are repeated together.
Duration Link::repeats(size_t bytes) {
  if (options_.loss <= 0) return {};
  bool is_lost = false;
  for (size_t packet = 0; packet <= bytes / LinkTrace::kPacketBytes; ++packet)
    is_lost = rng_.uniform() < options_.loss || is_lost;
  return is_lost ? options_.repeat_after : Duration{};
}

Bytes Link::receive() {
  Bytes message = std::move(on_the_way_.front().message);
  on_the_way_.pop_front();
  return message;
}

void Link::stall(Time now, Time end) {
  sent_ = std::max(sent_, end);
  for (Message& m : on_the_way_) {
    m.arrival = std::max(m.arrival, end);
    if (m.drained > now) m.drained = std::max(m.drained, end);
  }
  if (drained_ > now) drained_ = std::max(drained_, end);
  if (!on_the_way_.empty()) last_arrival_ = std::max(last_arrival_, on_the_way_.back().arrival);
}

void Link::dropUnsent(Time now) {
  while (!on_the_way_.empty() && on_the_way_.back().drained > now) on_the_way_.pop_back();
  sent_ = drained_ = std::min(drained_, now);
}

size_t Link::unsentBytes(Time now) const {
  size_t sum = 0;
  for (const Message& m : on_the_way_) sum += m.drained > now ? m.message.size() : 0;
  return sum;
}

Time Link::afterStalls(Time t) const {
  if (options_.stall.us == 0) return t;
  const int64_t into = t.us % options_.stall_every.us;
  return into < options_.stall.us ? t + Duration{options_.stall.us - into} : t;
}

}  // namespace foreland::sim
