#include "server/session/input/clock_map.h"

#include <algorithm>

#include "base/latency.h"

namespace foreland::server {

bool ClockMap::poseArrived(Time stamp_client, Time now) {
  const int64_t up_us = (now - stamp_client).us;
  const bool is_set_anew =
      last_stamp_ && (up_us < min_up_ - kMinStep_us || stamp_client.us < last_stamp_->us - kMinStep_us);
  if (is_set_anew) {
    up_.clear();
    down_.clear();
  }
  last_stamp_ = stamp_client;
  up_.push_back((now - stamp_client).us);
  if (up_.size() > kMemory) up_.pop_front();
  min_up_ = *std::min_element(up_.begin(), up_.end());
  if (down_.empty()) max_down_ = kFirstGuess_us - min_up_;
  return !is_set_anew;
}

void ClockMap::keyframeArrived(Time arrival_client, Time sent) {
  down_.push_back(arrival_client - sent);
  if (down_.size() > kMemory) down_.pop_front();
  max_down_ = slowestUsual(down_).us;
}

}  // namespace foreland::server
