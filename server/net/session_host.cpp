#include "server/net/session_host.h"

#include <algorithm>
#include <optional>
#include <utility>

#include "base/check.h"

namespace foreland::server {
namespace {

// Messages are read at once if a worker is free, but after keyframes whose deadlines lie within this time.
constexpr Duration kMessageTimeout = Duration::milliseconds(20);

}  // namespace

SessionHost::SessionHost(std::shared_ptr<const World> world, SessionOptions options, HostLimits limits, Pool& pool,
                         Clock clock, Metrics& metrics)
    : world_(std::move(world)),
      options_(options),
      limits_(limits),
      pool_(pool),
      clock_(std::move(clock)),
      metrics_(metrics),
      scratch_(pool.threadCount()) {}

SessionHost::~SessionHost() = default;

std::shared_ptr<SessionActor> SessionHost::open(Outlet outlet) {
  return std::make_shared<SessionActor>(*this, std::move(outlet));
}

SessionActor::SessionActor(SessionHost& host, Outlet outlet)
    : host_(host), session_(host.world_, host.options_), outlet_(std::move(outlet)) {
  ++host_.metrics_.sessions;
  ++host_.metrics_.sessions_opened;
}

SessionActor::~SessionActor() {
  const SessionStatistics& last = session_.statistics();
  host_.metrics_.section_nodes -= static_cast<int64_t>(last.section_nodes);
  host_.metrics_.remembered_nodes -= static_cast<int64_t>(last.remembered_nodes);
  host_.metrics_.memory_bytes -= static_cast<int64_t>(last.memory_bytes);
  --host_.metrics_.sessions;
}

Status SessionActor::deliver(Bytes message) {
  const std::lock_guard lock(mutex_);
  const HostLimits& limits = host_.limits_;
  if (inbox_.size() >= limits.inbox_messages || inbox_bytes_ + message.size() > limits.inbox_bytes)
    return Error{ErrorCode::kLimit, "you send more than this server can take in; send poses some 20 times a second"};
  inbox_bytes_ += message.size();
  enqueue({.time = host_.clock_(), .message = std::move(message)});
  return {};
}

void SessionActor::sent(uint64_t batches) {
  const std::lock_guard lock(mutex_);
  enqueue({.time = host_.clock_(), .message = std::nullopt, .sent_batches = batches});
}

void SessionActor::close() {
  const std::lock_guard lock(mutex_);
  closed_ = true;
  inbox_.clear();
  inbox_bytes_ = 0;
  if (lease_ == Lease::kQueued && host_.pool_.cancel(ticket_)) lease_ = Lease::kIdle;
}

void SessionActor::enqueue(Event event) {
  if (closed_) return;
  const Time now = event.time;
  inbox_.push_back(std::move(event));
  if (lease_ == Lease::kRunning) return;  // the worker that runs it reads the inbox before it returns the lease
  if (lease_ == Lease::kQueued) {
    if (ticket_.due.release <= now) return;
    if (!host_.pool_.cancel(ticket_)) return;  // a worker is about to take the lease
  }
  schedule({now, now + kMessageTimeout});
}

void SessionActor::schedule(Due due) {
  lease_ = Lease::kQueued;
  ticket_ = host_.pool_.submit(due, [self = shared_from_this()](size_t worker) { self->run(worker); });
}

void SessionActor::run(size_t worker) {
  std::deque<Event> events;
  if (!takeLease(events)) return;
  for (const Event& event : events) {
    if (const Status status = handle(event); !status.ok()) {
      refuse(status.error().message);
      break;
    }
  }
  stepIfDue(host_.scratch_[worker]);
  returnLease();
}

bool SessionActor::takeLease(std::deque<Event>& events) {
  const std::lock_guard lock(mutex_);
  CHECK_TRUE(lease_ == Lease::kQueued);
  lease_ = closed_ ? Lease::kIdle : Lease::kRunning;
  if (closed_) return false;
  events.swap(inbox_);
  inbox_bytes_ = 0;
  return true;
}

void SessionActor::returnLease() {
  const std::lock_guard lock(mutex_);
  lease_ = Lease::kIdle;
  if (closed_) return;
  const auto due = session_.due();
  const Time now = host_.clock_();
  if (!inbox_.empty())
    return schedule({now, due ? std::min(due->deadline, now + kMessageTimeout) : now + kMessageTimeout});
  if (due) schedule({due->release, due->deadline});
}

Status SessionActor::handle(const Event& event) {
  if (event.message) return session_.receive(*event.message, event.time);
  if (event.sent_batches == batches_posted_) session_.onDrained(event.time);
  return {};
}

void SessionActor::stepIfDue(SessionScratch& scratch) {
  {
    const std::lock_guard lock(mutex_);
    if (closed_) return;
  }
  const auto due = session_.due();
  const Time begin = host_.clock_();
  if (!due || due->release > begin) return;
  const SessionStatistics before = session_.statistics();
  std::vector<Bytes> out;
  session_.step(begin, scratch, out);
  const Time end = host_.clock_();
  session_.noteComputeTime(end - begin);
  countStep(before, due->deadline, begin, end);
  if (out.empty()) return;
  ++batches_posted_;
  outlet_.send(std::move(out));
}

void SessionActor::countStep(const SessionStatistics& before, Time deadline, Time begin, Time end) {
  const SessionStatistics& after = session_.statistics();
  Metrics& metrics = host_.metrics_;
  const uint64_t keyframes = after.keyframes - before.keyframes;
  metrics.keyframes += keyframes;
  metrics.skipped_keyframes += after.skipped_keyframes - before.skipped_keyframes;
  const auto change = [&](size_t SessionStatistics::*what) {
    return static_cast<int64_t>(after.*what) - static_cast<int64_t>(before.*what);
  };
  metrics.section_nodes += change(&SessionStatistics::section_nodes);
  metrics.remembered_nodes += change(&SessionStatistics::remembered_nodes);
  metrics.memory_bytes += change(&SessionStatistics::memory_bytes);
  metrics.compute.add(end - begin);
  if (end > deadline) metrics.late_keyframes += keyframes;
}

void SessionActor::refuse(const std::string& message) {
  {
    const std::lock_guard lock(mutex_);
    if (closed_) return;
    closed_ = true;
    inbox_.clear();
    inbox_bytes_ = 0;
  }
  outlet_.refuse(message);
}

}  // namespace foreland::server
