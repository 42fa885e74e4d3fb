// How much of the processors' time is used, by the thread for connections and by the whole process, of what they may
// use: a control group may give the process a part of a processor only (a container's limit). One owner, that thread.
#pragma once

#include <filesystem>
#include <optional>

#include "base/time.h"

namespace foreland::server {

// Of a time: of the last interval, and smoothed.
class UsedShare {
 public:
  static constexpr Duration kMemory = Duration::seconds(2);
  void add(double share, Duration elapsed);
  double last() const { return last_; }
  double mean() const { return mean_; }

 private:
  double last_ = 0, mean_ = 0;
};

class ProcessorUse {
 public:
  // Measures the time since the last call, by the thread that calls. Reads some small files of /proc and /sys; of what
  // is not there, nothing is known: then what waits counts as idle, and no control group limits anything.
  void update(Time now);

  // Of one thread's time: it ran, or could have run and waited for a processor.
  const UsedShare& thread() const { return thread_; }
  // Of the time of the processors that the process may use.
  const UsedShare& process() const { return process_; }

 private:
  std::optional<Time> updated_at_;
  Duration thread_used_, process_used_;
  UsedShare thread_, process_;
};

// How many processors a process may use that is at `path` below the root `groups` of its control groups (version 2 or
// 1); nothing if none of them limits it.
std::optional<double> processorQuota(const std::filesystem::path& groups, const std::filesystem::path& path);

}  // namespace foreland::server
