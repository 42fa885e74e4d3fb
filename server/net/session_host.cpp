#include "server/net/session_host.h"

#include <sys/resource.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "base/check.h"

namespace foreland::server {
namespace {

// Messages are read at once if a worker is free, but after keyframes whose deadlines lie within this time.
constexpr Duration kMessageTimeout = Duration::milliseconds(20);
// A message up to this size is taken in however much waits: there are few of them, by the limit of messages.
constexpr size_t kSmallMessage = 256;
// Replies that have no room are tried again after this time.
constexpr Duration kUntilRoom = Duration::milliseconds(100);
constexpr size_t kLargeSection = 500'000;  // nodes

// From the disk, by this thread, since it began: pages of the scene that were not in memory.
uint64_t pagesRead() {
  rusage usage{};
  return ::getrusage(RUSAGE_THREAD, &usage) == 0 ? static_cast<uint64_t>(usage.ru_majflt) : 0;
}

int64_t milli(double value) { return std::llround(1000 * value); }

}  // namespace

SessionHost::SessionHost(std::vector<std::shared_ptr<const World>> worlds, SessionOptions options, HostLimits limits,
                         Pool& pool, Clock clock, Metrics& metrics)
    : worlds_(std::move(worlds)),
      options_(options),
      limits_(limits),
      pool_(pool),
      clock_(std::move(clock)),
      metrics_(metrics),
      load_(pool.threadCount()),
      sessions_(worlds_.size()),
      scratch_(pool.threadCount()) {}

SessionHost::~SessionHost() = default;

std::shared_ptr<SessionActor> SessionHost::open(Outlet outlet, size_t max_nodes, size_t world) {
  SessionOptions options = options_;
  if (max_nodes > 0) options.max_section_nodes = std::min(options.max_section_nodes, max_nodes);
  options.occlusion_rank = OcclusionControl::rankOf(opened_++);
  return std::make_shared<SessionActor>(*this, options, std::move(outlet), world);
}

SessionActor::SessionActor(SessionHost& host, const SessionOptions& options, Outlet outlet, size_t world)
    : host_(host),
      world_(world),
      bytes_(std::make_shared<ViewerBytes>(host.limits_, host.metrics_)),
      session_(host.worlds_[world], options),
      outlet_(std::move(outlet)) {
  ++host_.metrics_.sessions;
  ++host_.sessions_[world_];
  ++host_.metrics_.sessions_opened;
  host_.load_.addViewer();
}

SessionActor::~SessionActor() {
  const SessionStatistics& last = session_.statistics();
  host_.metrics_.section_nodes -= static_cast<int64_t>(last.section_nodes);
  host_.metrics_.remembered_nodes -= static_cast<int64_t>(last.remembered_nodes);
  host_.metrics_.memory_bytes -= static_cast<int64_t>(last.memory_bytes);
  host_.metrics_.tolerances_mpx -= milli(last.tau_px);
  host_.metrics_.coarse -= last.is_coarse;
  host_.metrics_.lacking -= last.is_lacking;
  host_.metrics_.occluding -= last.is_occluding;
  host_.metrics_.left_out_nodes -= static_cast<int64_t>(last.left_out_nodes);
  if (last.keyframes > 0) --host_.metrics_.flying;
  --host_.metrics_.sessions;
  --host_.sessions_[world_];
}

Status SessionActor::deliver(Bytes message) {
  const std::lock_guard lock(mutex_);
  if (inbox_.size() >= host_.limits_.inbox_messages)
    return Error{ErrorCode::kLimit, "you send more than this server can take in; send poses some 20 times a second"};
  if (message.size() > kSmallMessage)
    if (Status room = bytes_->checkRoomFor(message.size()); !room.ok()) return room;
  inbox_bytes_ += message.size();
  bytes_->add(static_cast<int64_t>(message.size()));
  enqueue({.time = host_.clock_(), .message = std::move(message)});
  return {};
}

void SessionActor::sent(uint64_t batches) {
  const std::lock_guard lock(mutex_);
  enqueue({.time = host_.clock_(), .message = std::nullopt, .sent_batches = batches});
}

void SessionActor::forgetInbox() {
  bytes_->add(-static_cast<int64_t>(inbox_bytes_));
  inbox_.clear();
  inbox_bytes_ = 0;
}

void SessionActor::close() {
  const std::lock_guard lock(mutex_);
  closed_ = true;
  forgetInbox();
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
    lease_ = Lease::kIdle;
  }
  schedule(fairly({now, now + kMessageTimeout}));
}

void SessionActor::schedule(Due due) {
  ticket_ = host_.pool_.submit(due, [self = shared_from_this()](size_t worker) { self->run(worker); });
  lease_ = Lease::kQueued;
}

void SessionActor::run(size_t worker) {
  try {
    hold(worker);
  } catch (...) { fail(); }
}

// Needs no memory.
void SessionActor::fail() noexcept {
  ++host_.metrics_.failures;
  const std::lock_guard lock(mutex_);
  closed_ = true;
  lease_ = Lease::kIdle;
  forgetInbox();
  has_failed_ = true;
}

void SessionActor::hold(size_t worker) {
  std::deque<Event> events;
  if (!takeLease(events)) return;
  const Time begin = host_.clock_();
  SessionScratch& scratch = host_.scratch_[worker];
  try {
    work(scratch, events);
  } catch (...) {  // out of memory, say; the session is of no use any more
    ++host_.metrics_.failures;
    scratch = {};
    refuse("the server failed to serve you; connect again");
  }
  const Time end = host_.clock_();
  charge(end - begin, end);
  returnLease();
}

void SessionActor::work(SessionScratch& scratch, std::deque<Event>& events) {
  const Time begin = host_.clock_();
  for (const Event& event : events) {
    if (isClosed()) return;
    if (const Status status = handle(event); !status.ok()) return refuse(status.error().message);
  }
  events.clear();
  host_.metrics_.messages.add(host_.clock_() - begin);
  countKept();
  if (!bytes_->checkRoomFor(0).ok()) session_.postponeReplies(host_.clock_() + kUntilRoom);
  stepIfDue(scratch);
  countKept();
  // What a large section needs is not kept: other viewers' are smaller.
  if (session_.statistics().section_nodes > kLargeSection) scratch = {};
}

void SessionActor::countKept() {
  const auto kept = static_cast<int64_t>(session_.keptBytes());
  bytes_->add(kept - kept_bytes_);
  kept_bytes_ = kept;
}

// Pays the deficit at the even share, then adds to it.
void SessionActor::charge(Duration spent, Time now) {
  const Duration elapsed = now - std::exchange(charged_at_, now);
  deficit_.charge(spent, now, host_.load_.fairShare(host_.metrics_.flying));
  cost_ = Load::costAfter(cost(), spent, elapsed);
  host_.load_.add(spent, now);
  session_.setProcessors(host_.load_.processorsFor(cost(), host_.metrics_.flying), host_.load_.occlusionShare());
}

Due SessionActor::fairly(Due due) const {
  constexpr double kSmallDeficit_s = 0.1;
  constexpr Duration kShortStep = Duration::milliseconds(50);
  due.deadline = due.deadline + deficit_.wait(host_.load_.fairShare(host_.metrics_.flying));
  due.is_costly = due.is_costly || (deficit_.seconds() > kSmallDeficit_s && session_.computeTime() > kShortStep);
  return due;
}

bool SessionActor::takeLease(std::deque<Event>& events) {
  const std::lock_guard lock(mutex_);
  CHECK_TRUE(lease_ == Lease::kQueued);
  lease_ = closed_ ? Lease::kIdle : Lease::kRunning;
  is_lease_costly_ = ticket_.due.is_costly;
  is_lease_early_ = ticket_.due.release > host_.clock_();
  if (closed_) return false;
  events.swap(inbox_);
  forgetInbox();
  return true;
}

void SessionActor::returnLease() {
  const std::lock_guard lock(mutex_);
  lease_ = Lease::kIdle;
  if (closed_) return;
  const auto due = session_.due();
  const Time now = host_.clock_();
  if (!inbox_.empty())
    return schedule(fairly({now, due ? std::min(due->deadline, now + kMessageTimeout) : now + kMessageTimeout}));
  if (due) schedule(fairly(*due));
}

bool SessionActor::isClosed() {
  const std::lock_guard lock(mutex_);
  return closed_;
}

Status SessionActor::handle(const Event& event) {
  if (event.message) return session_.receive(*event.message, event.time);
  if (event.sent_batches == batches_posted_) session_.onDrained(event.time);
  return {};
}

void SessionActor::stepIfDue(SessionScratch& scratch) {
  const auto due = session_.due();
  const Time begin = host_.clock_();
  if (!due || isClosed()) return;
  const bool is_early = is_lease_early_ && due->release > begin && due->earliest && *due->earliest <= begin;
  if (due->release > begin && !is_early) return;
  if (fairly(*due).is_costly && !is_lease_costly_) return;  // in its own turn
  const SessionStatistics before = session_.statistics();
  std::vector<Bytes> out;
  const uint64_t read_before = pagesRead();
  session_.step(begin, scratch, out, is_early ? Session::Start::kEarly : Session::Start::kWhenDue);
  const Time end = host_.clock_();
  session_.noteComputeTime(end - begin, pagesRead() - read_before);
  countStep(before, due->deadline, begin, end);
  if (session_.statistics().keyframes > before.keyframes) host_.load_.addWait(begin - due->release);
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
  metrics.tolerances_mpx += milli(after.tau_px) - milli(before.tau_px);
  metrics.coarse += static_cast<int>(after.is_coarse) - static_cast<int>(before.is_coarse);
  metrics.lacking += static_cast<int>(after.is_lacking) - static_cast<int>(before.is_lacking);
  metrics.occluding += static_cast<int>(after.is_occluding) - static_cast<int>(before.is_occluding);
  metrics.left_out_nodes += change(&SessionStatistics::left_out_nodes);
  metrics.occlusion_us += static_cast<uint64_t>((after.occlusion_time - before.occlusion_time).us);
  metrics.occlusion_shed[0] += after.occlusion_shed - before.occlusion_shed;
  metrics.occlusion_shed[1] += after.occlusion_worthless - before.occlusion_worthless;
  metrics.replies += after.replies - before.replies;
  metrics.resumed += after.resumed && !before.resumed;
  metrics.jumps += after.jumps - jumps_counted_;
  jumps_counted_ = after.jumps;
  metrics.flying += after.keyframes > 0 && before.keyframes == 0;
  metrics.compute.add(end - begin);
  if (end > deadline) metrics.late_keyframes += keyframes;
}

void SessionActor::refuse(const std::string& message) {
  {
    const std::lock_guard lock(mutex_);
    if (closed_) return;
    closed_ = true;
    forgetInbox();
  }
  outlet_.refuse(message);
}

}  // namespace foreland::server
