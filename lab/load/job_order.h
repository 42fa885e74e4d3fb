// Which job a worker takes next: what the orders of a load say of each job that is queued. One owner, a run's.
#pragma once

#include <memory>

#include "lab/load/load_run.h"
#include "server/sched/deadline_queue.h"
#include "server/sched/deficit.h"

namespace foreland::lab {

// Whose job is queued, what its owner owes (Deficit), and an even share of one worker.
struct JobOwner {
  size_t viewer = 0;
  const server::Deficit& deficit;
  double share = 1;
};

// `LoadPolicy`'s kinds are one implementation, a program of the user's is another (load_programs.h).
class JobOrder {
 public:
  virtual ~JobOrder() = default;
  // Of the queues.
  virtual server::JobKey key() const = 0;
  // Changes what the key is made of before the job is queued.
  virtual void place(server::Due& job, const JobOwner& owner, Time now) = 0;
};
std::unique_ptr<JobOrder> makeOrder(LoadPolicy policy);

}  // namespace foreland::lab
