// Whom a server asks to connect elsewhere, because it is busier than the others: its costliest viewers, by the
// protocol's own migration (server/session/migration.h), until it is at the others' level. A balancer that weights
// servers by their load (HAProxy's agent-check) leads them to where there is room, and says how busy the others are
// (fleet_level.h). Where it does not say, a server that is overloaded asks so many at once that the rest can be served,
// more and more seldom while that does not help, for the others may be as busy. No clock; one owner.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "base/time.h"

namespace foreland::server {

class Rebalance {
 public:
  static constexpr double kGoal = 0.75;      // of the time, to be used afterwards, if the level is not known
  static constexpr double kUneven = 1.1;     // times the level: what is uneven
  static constexpr double kLeast = 0.3;      // of the time: who uses less has time for all of its viewers
  static constexpr double kMaxShare = 0.25;  // of the viewers, at once, if the level is not known
  static constexpr double kFewShare = 0.04;  // likewise, if it is: who resumes takes more than who flies
  static constexpr Duration kMinStay = Duration::seconds(10);  // of a viewer, before it is asked
  static constexpr Duration kMinPause = Duration::seconds(2), kMaxPause = Duration::seconds(60);

  struct Viewer {
    double cost = 0;  // of one worker's time, over some seconds
    Time since{};     // when it came
  };

  // How busy this server is, and the others are.
  struct Use {
    double load = 0;  // of late: the largest share that is used of the workers', the I/O thread's, the processors' time
    size_t workers = 1;
    double connections = 0;         // the share of the I/O thread's time that is used, over some seconds
    double processors = 0;          // likewise, of the processors' time, by all threads
    std::optional<double> fleet{};  // the mean of all servers (FleetLevel)
  };

  // Indices of those to ask at `now`, the costliest first; to be called once a second. What a viewer costs is its part
  // of the workers' time and, the same for each, of the I/O thread's. With a known level nobody is among them who costs
  // more than what is above it, and all of them together do not. O(viewers log viewers).
  std::vector<size_t> choose(std::span<const Viewer> viewers, const Use& use, Time now);

 private:
  Time next_{};
  Duration pause_ = kMinPause;
};

}  // namespace foreland::server
