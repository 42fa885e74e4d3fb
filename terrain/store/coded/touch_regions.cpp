#include "terrain/store/coded/touch_regions.h"

#include <signal.h>

#include <array>
#include <atomic>
#include <cerrno>
#include <mutex>

#include "base/check.h"

namespace foreland::terrain {

namespace {

// For a signal handler: fixed memory, and atomic numbers that it may read at any time. `begin` is written last and
// cleared first.
struct Region {
  std::atomic<uintptr_t> begin{0}, end{0};  // begin 0: free
  std::atomic<TouchOwner*> owner{nullptr};
};
std::array<Region, 64> regions;
std::mutex regions_mutex;  // of those who write
struct sigaction action_before {};

void passOn(int signal, siginfo_t* about, void* context) {
  if (action_before.sa_flags & SA_SIGINFO) return action_before.sa_sigaction(signal, about, context);
  if (action_before.sa_handler != SIG_DFL && action_before.sa_handler != SIG_IGN)
    return action_before.sa_handler(signal);
  ::signal(SIGSEGV, SIG_DFL);  // the load is done again, and ends the program
}

// Owners touch other parts. SA_NODEFER says so, too, but ThreadSanitizer blocks all signals in handlers.
void allowFaults() {
  sigset_t faults;
  ::sigemptyset(&faults);
  ::sigaddset(&faults, SIGSEGV);
  ::pthread_sigmask(SIG_UNBLOCK, &faults, nullptr);
}

void onFault(int signal, siginfo_t* about, void* context) {
  const int saved_errno = errno;
  const auto at = reinterpret_cast<uintptr_t>(about->si_addr);
  for (const Region& region : regions) {
    const uintptr_t begin = region.begin.load(std::memory_order_acquire);
    if (begin == 0 || at < begin || at >= region.end.load(std::memory_order_relaxed)) continue;
    allowFaults();
    region.owner.load(std::memory_order_relaxed)->onTouch(at);
    errno = saved_errno;
    return;
  }
  passOn(signal, about, context);
}

void install() {
  static std::once_flag once;
  std::call_once(once, [] {
    struct sigaction action {};
    action.sa_sigaction = onFault;
    action.sa_flags = SA_SIGINFO | SA_NODEFER;
    CHECK_EQ(::sigaction(SIGSEGV, &action, &action_before), 0);
  });
}

}  // namespace

TouchRegion::TouchRegion(const void* begin, size_t bytes, TouchOwner& owner) {
  install();
  const std::lock_guard lock(regions_mutex);
  for (index_ = 0; index_ < regions.size() && regions[index_].begin != 0;) ++index_;
  CHECK_LT(index_, regions.size());
  Region& region = regions[index_];
  region.owner = &owner;
  region.end = reinterpret_cast<uintptr_t>(begin) + bytes;
  region.begin.store(reinterpret_cast<uintptr_t>(begin), std::memory_order_release);
}

TouchRegion::~TouchRegion() {
  const std::lock_guard lock(regions_mutex);
  regions[index_].begin = 0;
}

}  // namespace foreland::terrain
