// The worker threads, which take released jobs from a DeadlineQueue, earliest deadline first. Of several workers one
// takes no costly jobs, so the others never wait for all of them. A job that throws ends its worker's turn and nothing
// else: `on_failure` is told. The queue's mutex is held
// to add and to take a job, never while a job runs. The server needs no other timer: a job may be released later. Any
// thread may submit and cancel, jobs too.
#pragma once

#include <atomic>
#include <condition_variable>
#include <functional>
#include <mutex>
#include <optional>
#include <thread>
#include <vector>

#include "server/sched/clock.h"
#include "server/sched/deadline_queue.h"
#include "server/sched/histogram.h"

namespace foreland::server {

class Pool {
 public:
  using Ticket = DeadlineQueue::Ticket;

  // Starts `threads` workers (at least one), named worker-0, worker-1, ... . `clock` decides which jobs are released
  // and which are late. Workers wait for a release in real time, so `clock` should run at its pace; a jump of `clock`
  // is noticed at the next submit().
  // `on_failure`, if any, is called by a worker with what() of whatever a job threw; it throws nothing itself.
  Pool(size_t threads, Clock clock, std::function<void(const char* what)> on_failure = {});
  ~Pool() { stop(); }
  Pool(const Pool&) = delete;
  Pool& operator=(const Pool&) = delete;

  // Queues a job; after stop() drops it.
  Ticket submit(Due due, Job job);

  // True if the job was queued and now will not run; false if it runs, has run or was dropped.
  bool cancel(const Ticket& ticket);

  // Waits for running jobs to end, joins the workers and drops the queued jobs. May be called again, but not by a job.
  void stop();

  size_t threadCount() const { return worker_count_; }
  // Jobs released and not yet started.
  size_t queueDepth() const { return ready_count_.load(std::memory_order_relaxed); }
  // By how much jobs ended after their deadline; jobs that ended in time count as zero.
  const Histogram& lateness() const { return lateness_; }

 private:
  void run(size_t worker, std::stop_token stop);
  void noteEnd(const Due& due);
  size_t mostCostly() const { return worker_count_ > 1 ? worker_count_ - 1 : 1; }
  std::optional<DeadlineQueue::Entry> next(std::stop_token stop);
  void waitForWork(std::unique_lock<std::mutex>& lock, std::stop_token stop);

  const Clock clock_;
  const size_t worker_count_;
  const std::function<void(const char*)> on_failure_;
  Histogram lateness_;
  std::atomic<size_t> ready_count_{0};

  std::mutex mutex_;  // protects queue_, costly_running_, changes_ and stopped_
  DeadlineQueue queue_;
  size_t costly_running_ = 0;
  uint64_t changes_ = 0;  // of the queue, so that no waiting worker misses one
  bool stopped_ = false;
  std::condition_variable_any changed_;

  std::vector<std::jthread> workers_;  // last: they use the members above from the moment they start
};

}  // namespace foreland::server
