// The order of jobs: of those whose release time has come, the one with the earliest deadline is next, or with the
// earliest key of another kind (JobKey); of equal keys, the one added first. Costly jobs wait while the taker wants
// none.
//
// Jobs are released as late as they can be, so that they use the newest pose; but if several are due together, some
// would end late though nobody worked before. So a job that permits it is started before its release when nothing is
// released and the jobs that wait, one after another, could not all end in time otherwise.
//
// Plain data without clock or lock; Pool protects it. Adding and cancelling cost O(log n), taking and nextRelease()
// O(log n + kLookAhead).
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <utility>

#include "base/time.h"
#include "server/sched/due.h"

namespace foreland::server {

// A job gets the number of the worker that runs it (0 to threads - 1), to find that worker's scratch. It neither blocks
// nor waits for other jobs, and throws nothing.
using Job = std::function<void(size_t worker)>;

// Of the released jobs, the one with the earliest key is next.
using JobKey = Time (*)(const Due&);
inline Time deadlineOf(const Due& due) { return due.deadline; }
inline Time toldKey(const Due& due) { return due.key; }

class DeadlineQueue {
 public:
  static constexpr size_t kLookAhead = 128;  // jobs that wait, by release

  explicit DeadlineQueue(size_t workers = 1, JobKey keyOf = deadlineOf)
      : workers_(static_cast<int64_t>(workers)), keyOf_(keyOf) {}

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

  // When a job may be taken next, of those not released at the last take(); nothing if there are none. May lie in the
  // past.
  std::optional<Time> nextRelease() const;

  size_t size() const { return waiting_.size() + readyCount(); }
  // How many jobs were released and not taken, as of the last take().
  size_t readyCount() const { return cheap_.size() + costly_.size(); }

 private:
  using Key = std::pair<Time, uint64_t>;
  using Jobs = std::map<Key, Entry>;

  void release(Time now);
  void releaseEarly(Time now);
  std::optional<Time> latestStart() const;
  std::optional<Time> earliestStart() const;
  Jobs::iterator makeReady(Jobs::iterator waiting);
  Jobs& readyOf(const Due& due) { return due.is_costly ? costly_ : cheap_; }

  int64_t workers_;
  JobKey keyOf_;
  Jobs waiting_;         // by release
  Jobs cheap_, costly_;  // released; by key
  uint64_t next_sequence_ = 0;
};

}  // namespace foreland::server
