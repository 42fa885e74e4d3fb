#include "server/sched/deadline_queue.h"

#include <algorithm>

namespace foreland::server {

DeadlineQueue::Ticket DeadlineQueue::add(Due due, Job job) {
  const uint64_t sequence = next_sequence_++;
  waiting_.emplace(Key{due.release, sequence}, Entry{due, std::move(job)});
  return {due, sequence};
}

std::optional<Job> DeadlineQueue::cancel(const Ticket& ticket) {
  auto node = waiting_.extract(Key{ticket.due.release, ticket.sequence});
  if (!node) node = readyOf(ticket.due).extract(Key{keyOf_(ticket.due), ticket.sequence});
  if (!node) return std::nullopt;
  return std::move(node.mapped().job);
}

std::optional<DeadlineQueue::Entry> DeadlineQueue::take(Time now, Take which) {
  release(now);
  const bool may_be_costly = which == Take::kAny && !costly_.empty();
  if (cheap_.empty() && !may_be_costly) releaseEarly(now);
  if (cheap_.empty() && !may_be_costly) return std::nullopt;
  const bool is_costly = may_be_costly && (cheap_.empty() || costly_.begin()->first < cheap_.begin()->first);
  Jobs& from = is_costly ? costly_ : cheap_;
  return std::move(from.extract(from.begin()).mapped());
}

std::optional<Time> DeadlineQueue::nextRelease() const {
  if (waiting_.empty()) return std::nullopt;
  const Time release = waiting_.begin()->first.first;
  const auto latest = latestStart(), earliest = earliestStart();
  return latest && earliest ? std::min(release, std::max(*latest, *earliest)) : release;
}

// By when work must begin if all jobs that wait are to end in time, one after another and shared by the workers.
std::optional<Time> DeadlineQueue::latestStart() const {
  std::optional<Time> latest;
  Duration sum;
  size_t count = 0;
  for (auto it = waiting_.begin(); it != waiting_.end() && count < kLookAhead; ++it) {
    const Due& due = it->second.due;
    if (due.work == Duration{}) continue;
    ++count;
    sum = sum + due.work;
    const Time start = due.deadline - std::max(due.work, Duration{sum.us / workers_});
    latest = latest ? std::min(*latest, start) : start;
  }
  return latest;
}

std::optional<Time> DeadlineQueue::earliestStart() const {
  std::optional<Time> earliest;
  size_t count = 0;
  for (auto it = waiting_.begin(); it != waiting_.end() && count < kLookAhead; ++it, ++count)
    if (const Due& due = it->second.due; due.earliest && !due.is_costly)
      earliest = earliest ? std::min(*earliest, *due.earliest) : *due.earliest;
  return earliest;
}

DeadlineQueue::Jobs::iterator DeadlineQueue::makeReady(Jobs::iterator waiting) {
  const auto next = std::next(waiting);
  auto node = waiting_.extract(waiting);
  const Due& due = node.mapped().due;
  node.key() = Key{keyOf_(due), node.key().second};
  readyOf(due).insert(std::move(node));
  return next;
}

void DeadlineQueue::release(Time now) {
  for (auto it = waiting_.begin(); it != waiting_.end() && it->first.first <= now;) it = makeReady(it);
}

// One job at a time, so that those that come after it keep the newest pose for as long as they can.
void DeadlineQueue::releaseEarly(Time now) {
  const auto latest = latestStart();
  if (!latest || *latest > now) return;
  auto best = waiting_.end();
  size_t count = 0;
  for (auto it = waiting_.begin(); it != waiting_.end() && count < kLookAhead; ++it, ++count) {
    const Due& due = it->second.due;
    const bool may_start = !due.is_costly && due.earliest && *due.earliest <= now;
    if (may_start && (best == waiting_.end() || keyOf_(due) < keyOf_(best->second.due))) best = it;
  }
  if (best != waiting_.end()) makeReady(best);
}

}  // namespace foreland::server
