#include "server/sched/deadline_queue.h"

namespace foreland::server {

DeadlineQueue::Ticket DeadlineQueue::add(Due due, Job job) {
  const uint64_t sequence = next_sequence_++;
  waiting_.emplace(Key{due.release, sequence}, Entry{due, std::move(job)});
  return {due, sequence};
}

std::optional<Job> DeadlineQueue::cancel(const Ticket& ticket) {
  auto node = waiting_.extract(Key{ticket.due.release, ticket.sequence});
  if (!node) node = readyOf(ticket.due).extract(Key{ticket.due.deadline, ticket.sequence});
  if (!node) return std::nullopt;
  return std::move(node.mapped().job);
}

std::optional<DeadlineQueue::Entry> DeadlineQueue::take(Time now, Take which) {
  release(now);
  const bool may_be_costly = which == Take::kAny && !costly_.empty();
  if (cheap_.empty() && !may_be_costly) return std::nullopt;
  const bool is_costly = may_be_costly && (cheap_.empty() || costly_.begin()->first < cheap_.begin()->first);
  Jobs& from = is_costly ? costly_ : cheap_;
  return std::move(from.extract(from.begin()).mapped());
}

std::optional<Time> DeadlineQueue::nextRelease() const {
  if (waiting_.empty()) return std::nullopt;
  return waiting_.begin()->first.first;
}

void DeadlineQueue::release(Time now) {
  while (!waiting_.empty() && waiting_.begin()->first.first <= now) {
    auto node = waiting_.extract(waiting_.begin());
    node.key() = Key{node.mapped().due.deadline, node.key().second};
    readyOf(node.mapped().due).insert(std::move(node));
  }
}

}  // namespace foreland::server
