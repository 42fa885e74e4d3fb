// Which job is next: those whose release time has come, earliest deadline first, equal deadlines in the order they
// came. Plain data without clock or lock; Pool protects it. Every operation costs O(log n).
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <utility>

#include "base/time.h"

namespace foreland::server {

// A function of its captures and the worker that runs it (0 .. threads - 1, to find that worker's scratch). It neither
// blocks nor waits for other jobs, and throws nothing.
using Job = std::function<void(size_t worker)>;

// When a job may start, and by when it should be done.
struct Due {
  Time release;
  Time deadline;
};

class DeadlineQueue {
 public:
  // Names one job of one queue for good.
  struct Ticket {
    Due due;
    uint64_t sequence = 0;
  };
  struct Entry {
    Due due;
    Job job;
  };

  Ticket add(Due due, Job job);

  // The job, to be destroyed outside the caller's lock; nothing if it was taken before.
  std::optional<Job> cancel(const Ticket& ticket);

  // The next job at `now`, or nothing if none is released.
  std::optional<Entry> take(Time now);

  // When the next job that waits will be released; nothing if none waits. A time in the past means: take() now.
  std::optional<Time> nextRelease() const;

  size_t size() const { return waiting_.size() + ready_.size(); }
  // Jobs that were released and not taken. As of the last take().
  size_t readyCount() const { return ready_.size(); }

 private:
  using Key = std::pair<Time, uint64_t>;
  using Jobs = std::map<Key, Entry>;

  void release(Time now);

  Jobs waiting_;  // by release
  Jobs ready_;    // by deadline
  uint64_t next_sequence_ = 0;
};

}  // namespace foreland::server
