#include "server/sched/pool.h"

#include <pthread.h>

#include <algorithm>
#include <chrono>
#include <string>
#include <utility>

#include "base/guarded.h"

namespace foreland::server {
namespace {
constexpr Duration kLongestWait =
    Duration::seconds(3600);  // so that std::condition_variable's sums of times do not overflow
}

Pool::Pool(size_t threads, Clock clock, std::function<void(const char*)> on_failure)
    : clock_(std::move(clock)),
      worker_count_(std::max<size_t>(1, threads)),
      on_failure_(std::move(on_failure)),
      queue_(worker_count_) {
  workers_.reserve(worker_count_);
  for (size_t worker = 0; worker < worker_count_; ++worker)
    workers_.emplace_back([this, worker](std::stop_token stop) { run(worker, stop); });
}

Pool::Ticket Pool::submit(Due due, Job job) {
  Ticket ticket{due, 0};
  {
    const std::lock_guard lock(mutex_);
    if (stopped_) return ticket;
    ticket = queue_.add(due, std::move(job));
    ++changes_;
  }
  changed_.notify_one();
  return ticket;
}

bool Pool::cancel(const Ticket& ticket) {
  std::optional<Job> dropped;  // destroyed after the lock: its destructor may submit or cancel
  const std::lock_guard lock(mutex_);
  dropped = queue_.cancel(ticket);
  ready_count_.store(queue_.readyCount(), std::memory_order_relaxed);
  return dropped.has_value();
}

void Pool::stop() {
  DeadlineQueue dropped;
  {
    const std::lock_guard lock(mutex_);
    stopped_ = true;
    dropped = std::exchange(queue_, DeadlineQueue());
    ready_count_.store(0, std::memory_order_relaxed);
  }
  for (std::jthread& worker : workers_) worker.request_stop();
  workers_.clear();  // joins
}

void Pool::run(size_t worker, std::stop_token stop) {
  pthread_setname_np(pthread_self(), ("worker-" + std::to_string(worker)).c_str());
  // Whoever submitted a job that throws must have put its own affairs in order.
  const auto tell = [this](const char* what) {
    if (on_failure_) on_failure_(what);
  };
  while (!stop.stop_requested())
    guarded(
        [&] {
          const auto entry = next(stop);
          if (!entry) return;
          guarded([&] { entry->job(worker); }, tell);
          noteEnd(entry->due);
        },
        tell);
}

void Pool::noteEnd(const Due& due) {
  if (due.is_costly) {
    const std::lock_guard lock(mutex_);
    --costly_running_;
  }
  lateness_.add(clock_() - due.deadline);
}

std::optional<DeadlineQueue::Entry> Pool::next(std::stop_token stop) {
  std::unique_lock lock(mutex_);
  while (!stop.stop_requested()) {
    const bool takes_costly = costly_running_ < mostCostly();
    auto entry = queue_.take(clock_(), takes_costly ? DeadlineQueue::Take::kAny : DeadlineQueue::Take::kCheap);
    ready_count_.store(queue_.readyCount(), std::memory_order_relaxed);
    if (entry) {
      costly_running_ += entry->due.is_costly;
      // Another worker is woken to wait for the jobs that are left, released or not, while this one is busy.
      if (queue_.size() > 0) {
        ++changes_;
        changed_.notify_one();
      }
      return entry;
    }
    waitForWork(lock, stop);
  }
  return std::nullopt;
}

void Pool::waitForWork(std::unique_lock<std::mutex>& lock, std::stop_token stop) {
  const auto changed = [this, seen = changes_] { return changes_ != seen; };
  const auto release = queue_.nextRelease();
  if (!release) {
    changed_.wait(lock, stop, changed);
    return;
  }
  const Duration wait = std::min(*release - clock_(), kLongestWait);
  changed_.wait_for(lock, stop, std::chrono::microseconds(wait.us), changed);
}

}  // namespace foreland::server
