#include "client/c/session.h"

#include <pthread.h>
#include <signal.h>

#include <algorithm>
#include <cfenv>
#include <utility>

namespace foreland::client {
namespace {

// The host's signals are for its own threads.
class SignalsBlocked {
 public:
  SignalsBlocked() {
    sigset_t all;
    sigfillset(&all);
    pthread_sigmask(SIG_SETMASK, &all, &before_);
  }
  ~SignalsBlocked() { pthread_sigmask(SIG_SETMASK, &before_, nullptr); }
  SignalsBlocked(const SignalsBlocked&) = delete;
  SignalsBlocked& operator=(const SignalsBlocked&) = delete;

 private:
  sigset_t before_{};
};

}  // namespace

Time sessionNow() {
  using Clock = std::chrono::steady_clock;
  static const Clock::time_point begin = Clock::now();
  return {std::chrono::duration_cast<std::chrono::microseconds>(Clock::now() - begin).count()};
}

Session::Session(SessionOptions options) : options_(std::move(options)) {
  const SignalsBlocked inherited;
  thread_ = std::jthread([this](const std::stop_token& stop) { run(stop); });
}

void Session::tell(ToSession message) {
  const std::lock_guard lock(mutex_);
  const auto isFrame = [](const ToSession& m) { return std::holds_alternative<told::Frame>(m); };
  const bool is_first = told_.empty();
  if (!told_.empty() && isFrame(told_.back()) && isFrame(message))
    told_.back() = std::move(message);
  else
    told_.push_back(std::move(message));
  if (is_first && running_ != nullptr) running_->wake();
  told_or_stopped_.notify_one();
}

void Session::take(std::vector<FromSession>& out) {
  out.clear();
  const std::lock_guard lock(mutex_);
  std::swap(out, posted_);
}

bool Session::wait(std::chrono::milliseconds longest) {
  std::unique_lock lock(mutex_);
  return has_posted_.wait_for(lock, longest, [this] { return !posted_.empty(); });
}

void Session::post(FromSession message) {
  const std::lock_guard lock(mutex_);
  posted_.push_back(std::move(message));
  has_posted_.notify_one();
}

// A thread inherits how its maker computes, and engines may have set denormals to be 0: both ends of a session must
// compute the same bits.
void Session::run(const std::stop_token& stop) {
  std::fesetenv(FE_DFL_ENV);
  pthread_setname_np(pthread_self(), "foreland");
  try {
    loop(stop);
  } catch (const std::exception& e) { post(from::Failed{e.what()}); } catch (...) {
    post(from::Failed{"an exception of an unknown kind"});
  }
}

void Session::loop(const std::stop_token& stop) {
  SessionLoop loop(options_, stop, [this](FromSession message) { post(std::move(message)); });
  const std::stop_callback on_stop(stop, [this] {
    const std::lock_guard lock(mutex_);
    if (running_) running_->wake();
  });
  std::vector<ToSession> told;
  while (!stop.stop_requested()) {
    takeTold(stop, loop, told);
    for (ToSession& message : told) loop.handle(std::move(message));
    loop.connectIfDue();
    if (!isToRun(loop)) continue;
    loop.run();
    if (!loop.connection()) isToRun(loop);  // lets go of one that is lost
  }
  loop.end();
}

// Where there is no connection to run, once there is something to do.
void Session::takeTold(const std::stop_token& stop, const SessionLoop& loop, std::vector<ToSession>& told) {
  told.clear();
  std::unique_lock lock(mutex_);
  if (!loop.connection()) told_or_stopped_.wait_for(lock, stop, loop.idle(), [this] { return !told_.empty(); });
  std::swap(told, told_);
}

// What is told from now on wakes the connection. What was told before does, too, so that a host that tells something
// all the time leaves the connection its turns.
bool Session::isToRun(const SessionLoop& loop) {
  std::shared_ptr<WebSocketClient> last = loop.connection();  // the one before ends after the lock
  const std::lock_guard lock(mutex_);
  std::swap(running_, last);
  if (running_ && !told_.empty()) running_->wake();
  return running_ != nullptr;
}

}  // namespace foreland::client
