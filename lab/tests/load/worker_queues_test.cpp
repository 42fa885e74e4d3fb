// Workers that share a queue, and workers that steal: jobs with random times, done in virtual time.
#include "lab/load/worker_queues.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <map>
#include <set>

#include "base/rng.h"
#include "tests/support/seed.h"

namespace foreland::lab {
namespace {

using server::deadlineOf;
using server::JobKey;

struct Planned {
  server::Due due;
  size_t home = 0;
};

std::vector<Planned> anyJobs(Rng& rng, size_t count) {
  std::vector<Planned> jobs(count);
  for (Planned& job : jobs) {
    job.home = rng.below(100);
    job.due.release = Time{static_cast<int64_t>(rng.below(1'000))};
    job.due.work = Duration{static_cast<int64_t>(1 + rng.below(20))};
    job.due.deadline = job.due.release + job.due.work + Duration{static_cast<int64_t>(rng.below(200))};
    job.due.is_costly = rng.below(10) == 0;
    if (rng.below(3) == 0) job.due.earliest = job.due.release - Duration{50};
  }
  return jobs;
}

// What was begun, in this order: which job, when, by whom.
struct Begun {
  size_t job;
  Time at;
  size_t worker;
  bool is_own;
  bool operator==(const Begun&) const = default;
};

// All jobs are known from the start. `idle` is called after each moment with the workers that have nothing to do.
template <class Idle>
std::vector<Begun> runAll(LoadQueues kind, size_t workers, JobKey keyOf, const std::vector<Planned>& jobs,
                          const Idle& idle) {
  WorkerQueues queues(kind, workers, keyOf);
  std::vector<Begun> begun;
  std::vector<Time> free_at(workers);
  Time now{-100};
  size_t begins = 0;  // the job that was taken
  for (size_t i = 0; i < jobs.size(); ++i) queues.add(jobs[i].home, jobs[i].due, [&begins, i](size_t) { begins = i; });
  for (; now < Time{20'000}; now = now + Duration{1}) {
    for (bool any = true; any;) {
      any = false;
      for (const bool is_own : {true, false})
        for (size_t worker = 0; worker < workers && !any; ++worker) {
          if (free_at[worker] > now) continue;
          auto entry = is_own ? queues.takeOwn(now, worker, WorkerQueues::Take::kAny)
                              : queues.steal(now, worker, WorkerQueues::Take::kAny);
          if (!entry) continue;
          entry->job(worker);
          begun.push_back({begins, now, worker, is_own});
          free_at[worker] = now + jobs[begins].due.work;
          any = true;
        }
    }
    idle(now, static_cast<size_t>(std::ranges::count_if(free_at, [&](Time t) { return t <= now; })), begun);
  }
  return begun;
}

void expectNothing(Time, size_t, const std::vector<Begun>&) {}

class Queues : public ::testing::TestWithParam<LoadQueues> {};

TEST_P(Queues, BeginEveryJobOnceAndLeaveNobodyIdle) {
  const uint64_t seed = test::randomSeed();
  SCOPED_TRACE(seed);
  Rng rng(seed);
  for (const size_t workers : {1, 2, 5}) {
    const std::vector<Planned> jobs = anyJobs(rng, 300);
    const auto idle = [&](Time now, size_t idle_workers, const std::vector<Begun>& begun) {
      if (idle_workers == 0) return;
      std::set<size_t> known;
      for (const Begun& b : begun) known.insert(b.job);
      for (size_t i = 0; i < jobs.size(); ++i)
        EXPECT_TRUE(known.contains(i) || jobs[i].due.release > now) << "job " << i << " waits at " << now.us;
    };
    const std::vector<Begun> begun = runAll(GetParam(), workers, deadlineOf, jobs, idle);
    std::set<size_t> all;
    for (const Begun& b : begun) EXPECT_TRUE(all.insert(b.job).second) << "job " << b.job << " was begun twice";
    EXPECT_EQ(all.size(), jobs.size());
    for (const Begun& b : begun)
      if (!jobs[b.job].due.earliest) { EXPECT_GE(b.at, jobs[b.job].due.release); }
  }
}

INSTANTIATE_TEST_SUITE_P(Kinds, Queues, ::testing::Values(LoadQueues::kShared, LoadQueues::kStealing));

TEST(WorkerQueues, OfOneWorkerAreTheSame) {
  const uint64_t seed = test::randomSeed();
  SCOPED_TRACE(seed);
  Rng rng(seed);
  const std::vector<Planned> jobs = anyJobs(rng, 400);
  const std::array<JobKey, 3> keys{deadlineOf, [](const server::Due& due) { return due.release; },
                                   [](const server::Due& due) { return due.deadline - due.work; }};
  for (const JobKey keyOf : keys)
    EXPECT_EQ(runAll(LoadQueues::kShared, 1, keyOf, jobs, expectNothing),
              runAll(LoadQueues::kStealing, 1, keyOf, jobs, expectNothing));
}

// A worker steals only when none of its own jobs is released, and takes its own by the order.
TEST(WorkerQueues, GiveAWorkerItsOwnJobsFirst) {
  const uint64_t seed = test::randomSeed();
  SCOPED_TRACE(seed);
  Rng rng(seed);
  constexpr size_t kWorkers = 3;
  std::vector<Planned> jobs = anyJobs(rng, 120);
  for (Planned& job : jobs) job.due.earliest.reset(), job.due.is_costly = false;
  const std::vector<Begun> begun = runAll(LoadQueues::kStealing, kWorkers, deadlineOf, jobs, expectNothing);
  std::set<size_t> waits;
  for (size_t i = 0; i < jobs.size(); ++i) waits.insert(i);
  size_t stolen = 0;
  for (const Begun& b : begun) {
    stolen += b.is_own ? 0 : 1;
    for (const size_t i : waits) {
      if (jobs[i].home % kWorkers != b.worker || jobs[i].due.release > b.at) continue;
      EXPECT_TRUE(b.is_own) << "stolen though job " << i << " waits";
      EXPECT_LE(jobs[b.job].due.deadline, jobs[i].due.deadline);
    }
    waits.erase(b.job);
  }
  EXPECT_GT(stolen, 10u);
}

}  // namespace
}  // namespace foreland::lab
