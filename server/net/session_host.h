// Runs sessions on the pool. Each is an actor: the I/O thread puts events into its inbox, and whichever worker holds
// its lease (at most one at a time) feeds them to the Session, steps it when it is due and hands its messages to the
// outlet.
//
// The inbox is bounded by HostLimits; the outbox too, since a Session computes no keyframe and no reply while an
// earlier one is unsent, and no reply while more is held for the viewer than may be (ViewerBytes). No lock is held
// while a Session works. Whatever a Session throws ends that viewer.
//
// Processor time is shared evenly where it is short. A viewer that has lately used more than its even share owes the
// rest: its deadlines are later by as long as it takes to pay at that share, its jobs count as costly (Pool) once it
// owes much, and its tolerance rises.
#pragma once

#include <atomic>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "base/bytes.h"
#include "base/result.h"
#include "server/net/host_limits.h"
#include "server/net/metrics/load.h"
#include "server/net/metrics/metrics.h"
#include "server/net/viewer_bytes.h"
#include "server/sched/deficit.h"
#include "server/sched/pool.h"
#include "server/session/session.h"

namespace foreland::server {

// Where a session's messages are sent to. Workers call it, in order and never two at a time; it must not block. After
// refuse nothing is called any more.
struct Outlet {
  std::function<void(std::vector<Bytes>)> send;     // a batch, never empty
  std::function<void(std::string message)> refuse;  // tells the viewer why, then closes
};

class SessionActor;

class SessionHost {
 public:
  // One or more worlds, which viewers of any share the pool for.
  SessionHost(std::vector<std::shared_ptr<const World>> worlds, SessionOptions options, HostLimits limits, Pool& pool,
              Clock clock, Metrics& metrics);
  ~SessionHost();

  // `max_nodes` of its section, at most; 0 for the server's limit. `world`: which it shows.
  std::shared_ptr<SessionActor> open(Outlet outlet, size_t max_nodes = 0, size_t world = 0);
  // Viewers connected, by world. Any thread.
  std::vector<int64_t> sessionsByWorld() const { return {sessions_.begin(), sessions_.end()}; }

  // The share of the workers' time that was used of late. Any thread.
  double load() const { return load_.busyAt(clock_()); }

 private:
  friend class SessionActor;

  const std::vector<std::shared_ptr<const World>> worlds_;
  const SessionOptions options_;
  const HostLimits limits_;
  Pool& pool_;
  const Clock clock_;
  Metrics& metrics_;
  Load load_;
  std::vector<std::atomic<int64_t>> sessions_;  // connected, by world
  uint64_t opened_ = 0;                         // sessions, by the I/O thread
  std::vector<SessionScratch> scratch_;         // one per worker, used by it alone
};

// One viewer's session and its inbox. The public functions belong to the I/O thread. The host outlives it.
class SessionActor : public std::enable_shared_from_this<SessionActor> {
 public:
  SessionActor(SessionHost& host, const SessionOptions& options, Outlet outlet, size_t world);
  ~SessionActor();

  // Where the connection counts what it holds, too.
  const std::shared_ptr<ViewerBytes>& bytes() const { return bytes_; }

  // Takes a whole message from the viewer. An Error means that there is no room for it, and the viewer is to be
  // refused.
  Status deliver(Bytes message);

  // To be called when the transport has sent `batches` of the outlet's batches in all.
  void sent(uint64_t batches);

  // Whether the session failed and could not even tell the outlet, for want of memory. It does nothing any more; the
  // viewer is to be refused.
  bool hasFailed() const { return has_failed_.load(std::memory_order_relaxed); }

  // Of one worker's time, over some seconds.
  double cost() const { return cost_.load(std::memory_order_relaxed); }

  // To be called when the viewer is gone. The session takes no further step; one in progress still ends.
  void close();

 private:
  enum class Lease : uint8_t { kIdle, kQueued, kRunning };
  struct Event {
    Time time;
    std::optional<Bytes> message;  // nothing if the event is that `sent_batches` has risen
    uint64_t sent_batches = 0;
  };

  void enqueue(Event event);  // with mutex_ held
  void schedule(Due due);     // with mutex_ held
  void run(size_t worker);
  void hold(size_t worker);
  void fail() noexcept;
  void work(SessionScratch& scratch, std::deque<Event>& events);
  Due fairly(Due due) const;  // with the lease, or with mutex_ held while nobody has it
  void charge(Duration spent, Time now);
  void forgetInbox();  // with mutex_ held
  void countKept();
  bool takeLease(std::deque<Event>& events);
  bool isClosed();
  void returnLease();
  Status handle(const Event& event);
  void stepIfDue(SessionScratch& scratch);
  void countStep(const SessionStatistics& before, Time deadline, Time begin, Time end);
  void refuse(const std::string& message);

  SessionHost& host_;
  const size_t world_;
  const std::shared_ptr<ViewerBytes> bytes_;

  std::mutex mutex_;  // protects what follows; held for a few instructions, and while submitting to the pool
  std::deque<Event> inbox_;
  size_t inbox_bytes_ = 0;
  Lease lease_ = Lease::kIdle;
  Pool::Ticket ticket_;  // while queued
  bool closed_ = false;
  std::atomic<bool> has_failed_{false};  // read without mutex_
  bool is_lease_costly_ = false;         // the job that took the lease is scheduled as costly
  bool is_lease_early_ = false;          // and was started before its release

  // Owned by the lease.
  Session session_;
  Outlet outlet_;
  uint64_t batches_posted_ = 0;
  uint64_t jumps_counted_ = 0;
  int64_t kept_bytes_ = 0;  // as counted last
  Time charged_at_;
  Deficit deficit_;              // of processor time used beyond the even share
  std::atomic<double> cost_{0};  // of one worker's time; smoothed over some seconds; set with the lease
};

}  // namespace foreland::server
