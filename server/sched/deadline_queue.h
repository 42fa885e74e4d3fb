// The order of jobs: of those whose release time has come, the one with the earliest deadline is next; of equal
// deadlines, the one added first. Costly jobs wait while the taker wants none. Plain data without clock or lock; Pool
// protects it. Every operation costs O(log n).
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <utility>

#include "base/time.h"

namespace foreland::server {

// A job gets the number of the worker that runs it (0 to threads - 1), to find that worker's scratch. It neither blocks
// nor waits for other jobs, and throws nothing.
using Job = std::function<void(size_t worker)>;

// When a job may start, and by when it should be done.
struct Due {
  Time release;
  Time deadline;
  bool is_costly = false;  // may take long, so that not all workers should run such jobs at a time (Pool)
};

class DeadlineQueue {
 public:
  // Identifies one job of one queue; tickets are never reused.
  struct Ticket {
    Due due;
    uint64_t sequence = 0;
  };
  struct Entry {
    Due due;
    Job job;
  };

  Ticket add(Due due, Job job);

  // Removes a job and returns it, so that it can be destroyed outside the caller's lock; nothing if it was taken
  // before.
  std::optional<Job> cancel(const Ticket& ticket);

  enum class Take : uint8_t { kAny, kCheap };
  // Removes the job that is next at `now` and returns it; nothing if none is released.
  std::optional<Entry> take(Time now, Take which = Take::kAny);

  // The earliest release among jobs not released at the last take(); nothing if there are none. May lie in the past.
  std::optional<Time> nextRelease() const;

  size_t size() const { return waiting_.size() + readyCount(); }
  // How many jobs were released and not taken, as of the last take().
  size_t readyCount() const { return cheap_.size() + costly_.size(); }

 private:
  using Key = std::pair<Time, uint64_t>;
  using Jobs = std::map<Key, Entry>;

  void release(Time now);
  Jobs& readyOf(const Due& due) { return due.is_costly ? costly_ : cheap_; }

  Jobs waiting_;         // by release
  Jobs cheap_, costly_;  // released; by deadline
  uint64_t next_sequence_ = 0;
};

}  // namespace foreland::server
