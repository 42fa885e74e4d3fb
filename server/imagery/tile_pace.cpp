#include "server/imagery/tile_pace.h"

#include <algorithm>

namespace foreland::server {

void TilePace::keyframeArrived(Time arrived_client, Time sent) {
  delays_us_.push_back(arrived_client.us - sent.us);
  if (delays_us_.size() > kMemory) delays_us_.pop_front();
  const Duration queued{delays_us_.back() - *std::min_element(delays_us_.begin(), delays_us_.end())};
  if (queued > kQueueing)
    bytes_per_second_ *= 0.7;
  else if (queued < kFree && was_used_up_)
    bytes_per_second_ *= 1.25;  // it doubles in three keyframes while tiles wait
  bytes_per_second_ = std::clamp(bytes_per_second_, kLeast, kMost);
}

void TilePace::keyframeSent(double interval_s, uint32_t max_bytes_per_second) {
  was_used_up_ = credit_ <= 0;
  double rate = bytes_per_second_;
  if (max_bytes_per_second > 0) rate = std::min(rate, 0.5 * max_bytes_per_second);
  // What was not used does not add up: it would be a burst.
  const double share = rate * std::clamp(interval_s, 0.0, 1.0);
  credit_ = std::min(credit_ + share, share);
}

void TilePace::sent(size_t bytes) { credit_ -= static_cast<double>(bytes); }

}  // namespace foreland::server
