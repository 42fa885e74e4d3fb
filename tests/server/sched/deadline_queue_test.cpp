// The order of jobs, compared with a plain list, and cancelling.
#include <gtest/gtest.h>

#include <rapidcheck.h>
#include <algorithm>
#include <vector>

#include "server/sched/deadline_queue.h"
#include "server/sched/histogram.h"

namespace foreland::server {
namespace {

struct Listed {
  Due due;
  size_t order;  // of arrival
};

// The rule itself: of the released jobs the one with the earliest deadline, of equal ones the first added.
std::optional<size_t> takeFromList(std::vector<Listed>& list, Time now) {
  auto best = list.end();
  for (auto it = list.begin(); it != list.end(); ++it)
    if (it->due.release <= now && (best == list.end() || it->due.deadline < best->due.deadline)) best = it;
  if (best == list.end()) return std::nullopt;
  const size_t order = best->order;
  list.erase(best);
  return order;
}

TEST(DeadlineQueue, TakesTheJobsOfAPlainListAtEveryTime) {
  EXPECT_TRUE(rc::check([] {
    const auto times = *rc::gen::container<std::vector<std::pair<uint8_t, uint8_t>>>(
        rc::gen::arbitrary<std::pair<uint8_t, uint8_t>>());
    DeadlineQueue queue;
    std::vector<Listed> list;
    size_t taken = 0;
    for (size_t i = 0; i < times.size(); ++i) {
      const Due due{{times[i].first % 16}, {times[i].second % 16}};
      queue.add(due, [&taken, i](size_t) { taken = i; });
      list.push_back({due, i});
    }
    for (int64_t now = 0; now < 16; ++now) {
      while (auto entry = queue.take({now})) {
        entry->job(0);
        RC_ASSERT(takeFromList(list, {now}) == taken);
      }
      RC_ASSERT(!takeFromList(list, {now}).has_value());
    }
    RC_ASSERT(queue.size() == 0u);
  }));
}

TEST(DeadlineQueue, CancelsWaitingAndReadyJobsOnce) {
  DeadlineQueue queue;
  const auto waiting = queue.add({{50}, {60}}, [](size_t) {});
  const auto ready = queue.add({{10}, {90}}, [](size_t) {});
  queue.add({{10}, {20}}, [](size_t) {});
  ASSERT_TRUE(queue.take({10}).has_value());
  EXPECT_EQ(queue.readyCount(), 1u);
  EXPECT_EQ(queue.nextRelease(), Time{50});
  EXPECT_TRUE(queue.cancel(ready).has_value());
  EXPECT_TRUE(queue.cancel(waiting).has_value());
  EXPECT_FALSE(queue.cancel(waiting).has_value());
  EXPECT_EQ(queue.size(), 0u);
  EXPECT_FALSE(queue.take({1'000}).has_value());
}

TEST(DeadlineQueue, LeavesCostlyJobsToWhoeverTakesThem) {
  DeadlineQueue queue;
  queue.add({Time{0}, Time{1}, true}, [](size_t) {});
  const auto later = queue.add({Time{0}, Time{3}, true}, [](size_t) {});
  queue.add({Time{0}, Time{2}}, [](size_t) {});
  EXPECT_EQ(queue.take(Time{5}, DeadlineQueue::Take::kCheap)->due.deadline, Time{2});
  EXPECT_FALSE(queue.take(Time{5}, DeadlineQueue::Take::kCheap));
  EXPECT_EQ(queue.readyCount(), 2u);
  EXPECT_EQ(queue.take(Time{5})->due.deadline, Time{1});
  EXPECT_TRUE(queue.cancel(later));
  EXPECT_FALSE(queue.take(Time{5}));
}

TEST(DeadlineQueue, DoesNotCancelWhatWasTaken) {
  DeadlineQueue queue;
  const auto ticket = queue.add({{0}, {0}}, [](size_t) {});
  ASSERT_TRUE(queue.take({0}).has_value());
  EXPECT_FALSE(queue.cancel(ticket).has_value());
}

TEST(Histogram, PutsSamplesIntoTheBucketThatHoldsThem) {
  Histogram histogram;
  histogram.add(Duration{-5});
  histogram.add(Histogram::kBounds[0]);
  histogram.add(Histogram::kBounds[0] + Duration{1});
  histogram.add(Duration::seconds(10));
  EXPECT_EQ(histogram.count(0), 2u);
  EXPECT_EQ(histogram.count(1), 1u);
  EXPECT_EQ(histogram.count(Histogram::kBounds.size()), 1u);
  EXPECT_EQ(histogram.sum(), Duration{100 + 101 + 10'000'000});
}

}  // namespace
}  // namespace foreland::server
