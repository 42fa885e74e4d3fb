// The queues of one server's workers. Shared: one for all, as servers have it (server/sched/pool.h). Stealing: one for
// each worker, in the same order of jobs; a worker whose own has nothing for it takes from those of the others, in turn
// after its own. That needs no lock that all workers meet at, and is how general pools are built (Blumofe and
// Leiserson, "Scheduling multithreaded computations by work stealing", 1999); but which jobs are due first, and that
// several are due together, only each queue knows of its own.
//
// Plain data without clock or lock. Cost: DeadlineQueue's, for a thief times the workers.
#pragma once

#include <optional>
#include <vector>

#include "server/sched/deadline_queue.h"

namespace foreland::lab {

enum class LoadQueues : uint8_t { kShared, kStealing };

class WorkerQueues {
 public:
  using Entry = server::DeadlineQueue::Entry;
  using Take = server::DeadlineQueue::Take;
  struct Ticket {
    size_t queue = 0;
    server::DeadlineQueue::Ticket job;
  };

  WorkerQueues(LoadQueues kind, size_t workers, server::JobKey keyOf);

  // Adds a job for the worker number `home`, which may be any number: workers are counted round.
  Ticket add(size_t home, server::Due due, server::Job job);
  void cancel(const Ticket& ticket);
  // The job that is next at `now` in the worker's own queue, and in those of the others.
  std::optional<Entry> takeOwn(Time now, size_t worker, Take which);
  std::optional<Entry> steal(Time now, size_t worker, Take which);
  // As DeadlineQueue's, over all queues.
  std::optional<Time> nextRelease() const;

 private:
  std::vector<server::DeadlineQueue> queues_;
};

}  // namespace foreland::lab
