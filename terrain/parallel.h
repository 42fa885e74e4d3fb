// Runs independent pieces of work on several threads and waits for them. The pieces must write to disjoint memory, so
// that the result does not depend on the number of threads. The calling thread works too, and only it calls `between`.
#pragma once

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <mutex>
#include <thread>
#include <utility>
#include <vector>

#include "base/result.h"

namespace foreland::terrain {

// 0 asks for one thread per processor.
inline unsigned threadCount(unsigned wanted) {
  return wanted ? wanted : std::max(1u, std::thread::hardware_concurrency());
}

// work(i, worker) for every i below `count`, in any order; calls with the same worker, below threadCount(threads), do
// not overlap, so each worker may own scratch. `between(done)` runs now and then on the calling thread; once it returns
// false no further piece is started. Returns whether every piece was done and nothing was stopped.
template <class Work, class Between>
bool parallelFor(uint64_t count, unsigned threads, const Work& work, const Between& between) {
  std::atomic<uint64_t> next{0}, done{0};
  std::atomic<bool> stop{false};
  const auto take = [&](unsigned worker, const auto& after) {
    for (uint64_t i; !stop.load(std::memory_order_relaxed) && (i = next.fetch_add(1)) < count;) {
      work(i, worker);
      after(done.fetch_add(1) + 1);
    }
  };
  {
    std::vector<std::jthread> others;
    const auto workers = static_cast<unsigned>(std::min<uint64_t>(threadCount(threads), count));
    for (unsigned worker = 1; worker < workers; ++worker)
      others.emplace_back([&, worker] { take(worker, [](uint64_t) {}); });
    take(0, [&](uint64_t finished) {
      if (!between(finished)) stop = true;
    });
  }
  return done == count && !stop;
}

// The first failure of pieces of work on several threads. keep() on any thread; status() once they have ended.
class FirstFailure {
 public:
  // Whether it is none.
  bool keep(Status status) {
    if (status.ok()) return true;
    const std::lock_guard lock(mutex_);
    if (first_.ok()) first_ = std::move(status);
    return false;
  }
  const Status& status() const { return first_; }

 private:
  std::mutex mutex_;
  Status first_;
};

}  // namespace foreland::terrain
