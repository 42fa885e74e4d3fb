// Whom a server that is overloaded asks to connect elsewhere: its costliest viewers, by the protocol's own migration
// (server/session/migration.h), so many that the rest can be served. A balancer that weights servers by their load
// (HAProxy's agent-check) leads them to where there is room. A server does not know how busy the others are: where all
// are, it asks more and more seldom. No clock; one owner.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "base/time.h"

namespace foreland::server {

class Rebalance {
 public:
  static constexpr double kGoal = 0.75;                        // of the workers' time, to be used afterwards
  static constexpr double kMaxShare = 0.25;                    // of the viewers, at once
  static constexpr Duration kMinStay = Duration::seconds(10);  // of a viewer, before it is asked
  static constexpr Duration kMinPause = Duration::seconds(2), kMaxPause = Duration::seconds(60);

  struct Viewer {
    double cost = 0;  // of one worker's time
    Time since{};     // when it came
  };

  // Indices of those to ask at `now`, the costliest first. `load` is the share of the time of `workers` that is used;
  // `is_overloaded` whether that is too much (Load::isOverloaded). O(viewers log viewers).
  std::vector<size_t> choose(std::span<const Viewer> viewers, double load, bool is_overloaded, size_t workers,
                             Time now);

 private:
  Time next_{};
  Duration pause_ = kMinPause;
};

}  // namespace foreland::server
