// What a user of shared workers owes: the time that it used beyond an even share, paid back at that share. Whoever owes
// waits, by having its deadlines set later. Plain data; one owner.
#pragma once

#include <algorithm>

#include "base/time.h"

namespace foreland::server {

class Deficit {
 public:
  static constexpr double kMax_s = 2;

  // Notes that `spent` was used until `now`, by a user whose even share of one worker is `share`.
  void charge(Duration spent, Time now, double share) {
    const double elapsed_s = std::max(1e-6, (now - charged_at_).toSeconds());
    charged_at_ = now;
    owed_s_ = std::max(0.0, owed_s_ - elapsed_s * share);
    owed_s_ = std::min(kMax_s, owed_s_ + spent.toSeconds());
  }
  double seconds() const { return owed_s_; }
  // How long it takes to pay.
  Duration wait(double share) const { return Duration::seconds(owed_s_ / share); }

 private:
  Time charged_at_;
  double owed_s_ = 0;
};

}  // namespace foreland::server
