// How busy one thread is: the share of time in which it ran, or could have run and waited for a processor (because
// others had them, or because the process has used up what a control group gives it), as the kernel counts both. One
// owner, the thread itself.
#pragma once

#include <optional>

#include "base/time.h"

namespace foreland::server {

class ThreadUse {
 public:
  static constexpr Duration kMemory = Duration::seconds(2);  // of mean()

  // Measures the time since the last call. Reads a file of /proc; where that is not there, what waits counts as idle.
  void update(Time now);

  double last() const { return last_; }  // between the last two calls
  double mean() const { return mean_; }  // smoothed

 private:
  std::optional<Time> updated_at_;
  Duration used_{};
  double last_ = 0, mean_ = 0;
};

}  // namespace foreland::server
