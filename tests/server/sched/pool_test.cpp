// The workers: order, waiting for a release, stopping. No test waits longer than it must, and none judges a duration.
#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <latch>
#include <mutex>
#include <semaphore>
#include <stdexcept>
#include <string>
#include <vector>

#include "server/sched/pool.h"

namespace foreland::server {
namespace {

Time steadyNow() {
  using namespace std::chrono;
  return {duration_cast<microseconds>(steady_clock::now().time_since_epoch()).count()};
}

const Clock kFrozen = [] { return Time{100}; };
constexpr Due kNow{{0}, {0}};

TEST(Pool, RunsEarliestDeadlineFirst) {
  Pool pool(1, kFrozen);
  std::latch started(1), go(1), done(4);
  std::vector<int> order;  // only the one worker writes it
  pool.submit(kNow, [&](size_t) {
    started.count_down();
    go.wait();
  });
  started.wait();
  const auto note = [&](int name) {
    return [&order, &done, name](size_t) {
      order.push_back(name);
      done.count_down();
    };
  };
  pool.submit({{0}, {30}}, note(3));
  pool.submit({{0}, {10}}, note(1));
  pool.submit({{0}, {20}}, note(2));
  pool.submit({{0}, {30}}, note(4));
  go.count_down();
  done.wait();
  EXPECT_EQ(order, (std::vector<int>{1, 2, 3, 4}));
}

TEST(Pool, RunsAJobAtItsReleaseAndNotBefore) {
  Pool pool(2, steadyNow);
  std::latch done(8);
  std::atomic<int> early{0};
  for (int i = 0; i < 8; ++i) {
    const Time release = steadyNow() + Duration::milliseconds(5 * i);
    pool.submit({release, release}, [&, release](size_t) {
      if (steadyNow() < release) ++early;
      done.count_down();
    });
  }
  done.wait();
  EXPECT_EQ(early, 0);
}

// Both workers must be at work for the latch to open: no job may sleep in the queue while a worker is free.
TEST(Pool, UsesAllWorkers) {
  Pool pool(3, steadyNow);
  for (int round = 0; round < 200; ++round) {
    std::latch together(3), done(3);
    const Time release = steadyNow() + Duration{round % 3 * 100};
    for (int i = 0; i < 3; ++i)
      pool.submit({release, release}, [&](size_t) {
        together.arrive_and_wait();
        done.count_down();
      });
    done.wait();
  }
}

// The worker that watched the time leaves for a long job; another one must take the watch over.
TEST(Pool, WatchesTheTimeWhileAWorkerIsBusy) {
  Pool pool(2, steadyNow);
  for (int round = 0; round < 50; ++round) {
    std::latch second_ran(1), done(1);
    const Time now = steadyNow();
    pool.submit({now + Duration{1'000}, now}, [&](size_t) {
      second_ran.wait();
      done.count_down();
    });
    pool.submit({now + Duration{2'000}, now}, [&](size_t) { second_ran.count_down(); });
    done.wait();
  }
}

TEST(Pool, CancelsOnlyWhatDoesNotRun) {
  std::latch started(1), go(1);  // outlive the pool, whose job may still wait
  Pool pool(1, kFrozen);
  const auto running = pool.submit(kNow, [&](size_t) {
    started.count_down();
    go.wait();
  });
  const auto future = pool.submit({{1'000'000'000}, {0}}, [](size_t) { FAIL(); });
  started.wait();
  EXPECT_FALSE(pool.cancel(running));
  EXPECT_TRUE(pool.cancel(future));
  EXPECT_FALSE(pool.cancel(future));
  go.count_down();
}

TEST(Pool, StopEndsTheRunningJobAndDropsTheRest) {
  auto held = std::make_shared<int>(0);
  std::atomic<bool> ended{false};
  Pool pool(1, kFrozen);
  std::latch started(1);
  pool.submit(kNow, [&](size_t) {
    started.count_down();
    ended = true;
  });
  pool.submit({{1'000'000'000}, {0}}, [held](size_t) { FAIL(); });
  started.wait();
  pool.stop();
  EXPECT_TRUE(ended);
  EXPECT_EQ(held.use_count(), 1);
  pool.submit(kNow, [held](size_t) { FAIL(); });
  EXPECT_EQ(held.use_count(), 1);
}

TEST(Pool, JobsMaySubmitJobs) {
  Pool pool(2, steadyNow);
  std::latch done(1);
  std::atomic<int> left{1000};
  std::function<void(size_t)> again = [&](size_t) {
    if (--left == 0)
      done.count_down();
    else
      pool.submit(kNow, again);
  };
  pool.submit(kNow, again);
  done.wait();
  pool.stop();
  EXPECT_EQ(left, 0);
}

// Both costly jobs wait until they are told to go on; if they took both workers, the cheap one could not tell them.
TEST(Pool, OneWorkerTakesNoCostlyJobs) {
  Pool pool(2, steadyNow);
  std::latch all(3);
  std::binary_semaphore go{0};
  for (int i = 0; i < 2; ++i)
    pool.submit({Time{}, Time{}, true}, [&](size_t) {
      go.acquire();
      go.release();
      all.count_down();
    });
  pool.submit({Time{}, Time{1}}, [&](size_t) {
    go.release();
    all.count_down();
  });
  all.wait();
}

TEST(Pool, GoesOnAfterAJobThatThrows) {
  std::string told;
  std::latch done(1);
  Pool pool(1, steadyNow, [&](const char* what) { told = what; });
  pool.submit({Time{}, Time{}}, [](size_t) { throw std::runtime_error("no memory"); });
  pool.submit({Time{}, Time{1}}, [&](size_t) { done.count_down(); });
  done.wait();
  EXPECT_EQ(told, "no memory");
}

TEST(Pool, CountsLateJobs) {
  Pool pool(1, kFrozen);  // it is always 100
  pool.submit({{0}, {100}}, [](size_t) {});
  pool.submit({{0}, {0}}, [](size_t) {});
  std::latch done(1);
  pool.submit({{0}, {200}}, [&](size_t) { done.count_down(); });
  done.wait();
  pool.stop();
  EXPECT_EQ(pool.lateness().count(0), 3u);
  EXPECT_EQ(pool.lateness().sum(), Duration{100});
}

}  // namespace
}  // namespace foreland::server
