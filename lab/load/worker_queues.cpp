#include "lab/load/worker_queues.h"

#include <algorithm>
#include <utility>

namespace foreland::lab {

WorkerQueues::WorkerQueues(LoadQueues kind, size_t workers, server::JobKey keyOf) {
  if (kind == LoadQueues::kShared)
    queues_.emplace_back(workers, keyOf);
  else
    for (size_t worker = 0; worker < workers; ++worker) queues_.emplace_back(1, keyOf);
}

WorkerQueues::Ticket WorkerQueues::add(size_t home, server::Due due, server::Job job) {
  const size_t queue = home % queues_.size();
  return {queue, queues_[queue].add(due, std::move(job))};
}

void WorkerQueues::cancel(const Ticket& ticket) { (void)queues_[ticket.queue].cancel(ticket.job); }

std::optional<WorkerQueues::Entry> WorkerQueues::takeOwn(Time now, size_t worker, Take which) {
  return queues_[worker % queues_.size()].take(now, which);
}

std::optional<WorkerQueues::Entry> WorkerQueues::steal(Time now, size_t worker, Take which) {
  for (size_t other = 1; other < queues_.size(); ++other)
    if (auto entry = queues_[(worker + other) % queues_.size()].take(now, which)) return entry;
  return std::nullopt;
}

std::optional<Time> WorkerQueues::nextRelease() const {
  std::optional<Time> next;
  for (const server::DeadlineQueue& queue : queues_)
    if (const auto release = queue.nextRelease()) next = next ? std::min(*next, *release) : *release;
  return next;
}

}  // namespace foreland::lab
