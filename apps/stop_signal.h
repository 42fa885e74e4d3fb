// How the programs stop on Ctrl-C (SIGINT) and SIGTERM. A program uses one of the two ways: it works on its main thread
// and looks at a flag now and then, or its threads work and the main thread waits. Header only.
#pragma once

#include <pthread.h>

#include <atomic>
#include <csignal>

namespace foreland::apps {

namespace detail {
inline std::atomic<bool> g_stop_requested{false};
static_assert(std::atomic<bool>::is_always_lock_free, "a signal handler may only touch lock-free atomics");
}  // namespace detail

// From now on the two signals set the flag that isStopRequested() reads, instead of ending the process.
inline void catchStopSignals() {
  const auto note = [](int) { detail::g_stop_requested = true; };
  std::signal(SIGINT, note);
  std::signal(SIGTERM, note);
}

// Whether one of the signals has arrived since catchStopSignals(). Any thread.
inline bool isStopRequested() { return detail::g_stop_requested.load(); }

// Keeps the two signals, and SIGHUP, from this thread and from every thread that it starts later, so that only
// waitForSignal() takes them. Main thread, before any other thread starts.
inline sigset_t blockStopSignals() {
  sigset_t signals;
  sigemptyset(&signals);
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) sigaddset(&signals, signal);
  pthread_sigmask(SIG_BLOCK, &signals, nullptr);
  return signals;
}

// Returns which of the blocked signals has arrived.
inline int waitForSignal(const sigset_t& signals) {
  int signal = 0;
  sigwait(&signals, &signal);
  return signal;
}

// From now on another signal to stop ends the process at once. SIGHUP, which asks for something else, does nothing.
inline void endOnFurtherSignals(sigset_t signals) {
  sigdelset(&signals, SIGHUP);
  pthread_sigmask(SIG_UNBLOCK, &signals, nullptr);
}

}  // namespace foreland::apps
