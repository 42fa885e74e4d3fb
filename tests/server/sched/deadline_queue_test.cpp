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

// A job that takes `work` until `deadline`, and may be started up to `early` sooner.
Due planned(int64_t deadline, int64_t work, int64_t early) {
  return {Time{deadline - work}, Time{deadline}, false, Duration{work}, Time{deadline - work - early}};
}

TEST(DeadlineQueue, StartsJobsEarlyThatWouldCollide) {
  DeadlineQueue queue;
  for (int i = 0; i < 4; ++i) queue.add(planned(1000, 10, 500), [](size_t) {});
  EXPECT_EQ(queue.nextRelease(), Time{960});  // four of them take 40
  EXPECT_FALSE(queue.take(Time{959}));
  for (const int64_t at : {960, 970, 980, 990}) {
    EXPECT_TRUE(queue.take(Time{at})) << at;
    EXPECT_FALSE(queue.take(Time{at})) << at;
  }
}

TEST(DeadlineQueue, StartsNoJobEarlyWithoutNeedOrPermission) {
  DeadlineQueue queue;
  queue.add(planned(1000, 10, 500), [](size_t) {});
  queue.add(planned(1100, 10, 500), [](size_t) {});
  EXPECT_EQ(queue.nextRelease(), Time{990});
  EXPECT_FALSE(queue.take(Time{989}));
  DeadlineQueue strict;
  strict.add({Time{990}, Time{1000}, false, Duration{10}}, [](size_t) {});
  strict.add(planned(1000, 10, 5), [](size_t) {});
  EXPECT_EQ(strict.nextRelease(), Time{985});  // from when the one that may be early may be
  EXPECT_FALSE(strict.take(Time{984}));
  EXPECT_EQ(strict.take(Time{985})->due.earliest, Time{985});
  EXPECT_FALSE(strict.take(Time{986}));
}

// Whatever jobs wait: if one worker can do all in time at all, starting them early does so.
TEST(DeadlineQueue, EndsAllInTimeThatCanBeDoneInTime) {
  EXPECT_TRUE(rc::check([] {
    const auto deadlines = *rc::gen::container<std::vector<int64_t>>(rc::gen::inRange<int64_t>(2000, 3000));
    constexpr int64_t kWork = 20;
    DeadlineQueue queue;
    for (const int64_t deadline : deadlines) queue.add(planned(deadline, kWork, 2000), [](size_t) {});
    RC_PRE(deadlines.size() < DeadlineQueue::kLookAhead && kWork * deadlines.size() < 1000);
    Time now;
    while (queue.size() > 0) {
      if (auto entry = queue.take(now)) {
        now = now + entry->due.work;
        RC_ASSERT(now <= entry->due.deadline);
      } else {
        const Time next = *queue.nextRelease();
        RC_ASSERT(next > now);
        now = next;
      }
    }
  }));
}

TEST(DeadlineQueue, OrdersByAnotherKeyIfAskedTo) {
  const auto first = [](JobKey keyOf) {
    DeadlineQueue queue(1, keyOf);
    queue.add({Time{5}, Time{100}, false, Duration{90}}, [](size_t) {});
    queue.add({Time{1}, Time{80}, false, Duration{10}}, [](size_t) {});
    queue.add({Time{6}, Time{60}, false, Duration{10}}, [](size_t) {});
    return queue.take(Time{10})->due.deadline;
  };
  EXPECT_EQ(first(deadlineOf), Time{60});
  EXPECT_EQ(first([](const Due& due) { return due.release; }), Time{80});
  EXPECT_EQ(first([](const Due& due) { return due.deadline - due.work; }), Time{100});
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
