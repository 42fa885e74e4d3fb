// Does pieces of work on several threads, and takes their results on the calling thread in the order in which the
// pieces came, so that what is made of the results does not depend on the number of threads. With one worker there is
// no thread: a piece is done when it is added. One owner, on whose thread results are taken.
#pragma once

#include <pthread.h>

#include <algorithm>
#include <condition_variable>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

namespace foreland::oracle {

// 0 asks for one thread per processor.
inline unsigned workerCount(unsigned wanted) {
  return wanted > 0 ? wanted : std::max(1u, std::thread::hardware_concurrency());
}

template <class Piece, class Result>
class OrderedWork {
 public:
  // Calls of work(piece, worker) with the same worker, below `workers`, do not overlap, so each may own scratch.
  using Work = std::function<Result(const Piece&, unsigned worker)>;
  using Take = std::function<void(Result)>;

  OrderedWork(unsigned workers, Work work, Take take)
      : work_(std::move(work)), take_(std::move(take)), most_(size_t{2} * workers) {
    if (workers < 2) return;
    for (unsigned worker = 0; worker < workers; ++worker)
      threads_.emplace_back([this, worker](std::stop_token stop) { run(stop, worker); });
  }
  // Pieces that nobody has begun are dropped, and results that were not taken.
  ~OrderedWork() {
    for (std::jthread& thread : threads_) thread.request_stop();
  }
  OrderedWork(const OrderedWork&) = delete;
  OrderedWork& operator=(const OrderedWork&) = delete;

  // Takes what is done; waits while there are two pieces for each worker.
  void add(Piece piece) {
    if (threads_.empty()) {
      take_(work_(piece, 0));
      return;
    }
    {
      const std::scoped_lock lock(mutex_);
      pieces_.push_back(std::make_unique<Entry>(std::move(piece)));
      unbegun_.push_back(pieces_.back().get());
    }
    is_added_.notify_one();
    takeUntil(most_);
  }
  // Waits for all pieces, and takes their results.
  void finish() { takeUntil(0); }

 private:
  struct Entry {
    explicit Entry(Piece p) : piece(std::move(p)) {}
    std::optional<Piece> piece;
    std::optional<Result> result;
  };

  // The results of the oldest pieces: those that are done, and as many more as leave `most` pieces.
  void takeUntil(size_t most) {
    while (!pieces_.empty()) {
      std::unique_ptr<Entry> oldest;
      {
        std::unique_lock lock(mutex_);
        if (pieces_.size() > most) is_done_.wait(lock, [this] { return pieces_.front()->result.has_value(); });
        if (!pieces_.front()->result) return;
        oldest = std::move(pieces_.front());
        pieces_.pop_front();
      }
      take_(std::move(*oldest->result));
    }
  }

  void run(const std::stop_token& stop, unsigned worker) {
    pthread_setname_np(pthread_self(), ("judge-" + std::to_string(worker)).c_str());
    for (std::unique_lock lock(mutex_); is_added_.wait(lock, stop, [this] { return !unbegun_.empty(); });) {
      if (stop.stop_requested()) return;
      Entry& entry = *unbegun_.front();
      unbegun_.pop_front();
      lock.unlock();
      Result result = work_(*entry.piece, worker);
      entry.piece.reset();
      lock.lock();
      entry.result = std::move(result);
      is_done_.notify_one();
    }
  }

  const Work work_;
  const Take take_;
  const size_t most_;
  std::mutex mutex_;  // protects unbegun_ and results; pieces_ belong to the owner
  std::condition_variable_any is_added_, is_done_;
  std::deque<std::unique_ptr<Entry>> pieces_;  // in order
  std::deque<Entry*> unbegun_;
  std::vector<std::jthread> threads_;  // last: they use the members above
};

}  // namespace foreland::oracle
