#include "server/session/clock_map.h"

#include <algorithm>

#include "base/latency.h"

namespace foreland::server {

void ClockMap::poseArrived(Time stamp_client, Time now) {
  up_.push_back((now - stamp_client).us);
  if (up_.size() > kMemory) up_.pop_front();
  least_up_ = *std::min_element(up_.begin(), up_.end());
  if (down_.empty()) most_down_ = kFirstGuess_us - least_up_;
}

void ClockMap::keyframeArrived(Time arrival_client, Time sent) {
  down_.push_back(arrival_client - sent);
  if (down_.size() > kMemory) down_.pop_front();
  most_down_ = slowestUsual(down_).us;
}

}  // namespace foreland::server
