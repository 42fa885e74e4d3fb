// How busy the servers of a fleet are on average, itself included, as its balancer says with each check of /readyz:
// HAProxy's X-Haproxy-Server-State (http-check send-state) holds the weight of all servers that take viewers, which
// each has told it (--agent-listen, Load::weightPercent); X-Foreland-Servers, how many these are. No clock; one owner.
#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

#include "base/time.h"

namespace foreland::server {

class FleetLevel {
 public:
  static constexpr Duration kMemory = Duration::seconds(2);   // over which what is said is smoothed, as costs are
  static constexpr Duration kLasting = Duration::seconds(5);  // of what was said last
  static constexpr uint64_t kMaxServers = 10'000;

  // Notes the values of the two fields. What does not make sense is ignored.
  void note(std::string_view state, std::string_view servers, Time now);

  // The share of a server's time that is used, in the mean over those that take viewers: 0 to Load::kBusy, for a weight
  // tells no more, and 1 where none takes any. Nothing if no balancer has said it of late.
  std::optional<double> at(Time now) const;

 private:
  double level_ = 0;
  std::optional<Time> noted_at_;
};

}  // namespace foreland::server
