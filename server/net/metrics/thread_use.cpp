#include "server/net/metrics/thread_use.h"

#include <sys/resource.h>

#include <algorithm>
#include <cmath>
#include <fstream>

namespace foreland::server {
namespace {

// Of the calling thread, since it began: https://docs.kernel.org/scheduler/sched-stats.html
Duration ranOrWaited() {
  std::ifstream file("/proc/thread-self/schedstat");
  int64_t ran_ns = 0, waited_ns = 0;
  if (file >> ran_ns >> waited_ns) return {(ran_ns + waited_ns) / 1000};
  rusage usage{};
  if (::getrusage(RUSAGE_THREAD, &usage) != 0) return {};
  const auto microseconds = [](const timeval& t) { return int64_t{t.tv_sec} * 1'000'000 + t.tv_usec; };
  return {microseconds(usage.ru_utime) + microseconds(usage.ru_stime)};
}

}  // namespace

void ThreadUse::update(Time now) {
  const Duration used = ranOrWaited();
  if (updated_at_ && now > *updated_at_) {
    const Duration elapsed = now - *updated_at_;
    last_ = std::clamp((used - used_).toSeconds() / elapsed.toSeconds(), 0.0, 1.0);
    mean_ += (1 - std::exp(-elapsed.toSeconds() / kMemory.toSeconds())) * (last_ - mean_);
  }
  updated_at_ = now;
  used_ = used;
}

}  // namespace foreland::server
