// When the workers count as too busy for further viewers, which /readyz tells.
#include "server/net/metrics/load.h"

#include <gtest/gtest.h>

#include <cmath>
#include <ctime>
#include <filesystem>
#include <fstream>

#include "server/net/metrics/processor_use.h"
#include "tests/support/files.h"

namespace foreland::server {
namespace {

Time ms(int64_t t) { return Time{} + Duration::milliseconds(t); }

// Two workers, each busy for `share` of the time, from `begin` on for two seconds.
void work(Load& load, double share, int64_t begin_ms) {
  for (int64_t t = begin_ms; t < begin_ms + 2000; t += 50) load.add(Duration::seconds(0.05 * 2 * share), ms(t + 50));
}

bool isOverloaded(const Load& load, Time now) { return load.busyAt(now) > Load::kBusy; }

TEST(Load, IsOverloadedWhileWorkersAreBusyAndNotLongAfter) {
  Load load(2);
  EXPECT_FALSE(isOverloaded(load, ms(0)));
  work(load, 0.5, 0);
  EXPECT_NEAR(load.busy(), 0.5, 0.06);
  EXPECT_FALSE(isOverloaded(load, ms(2000)));
  work(load, 0.97, 2000);
  EXPECT_TRUE(isOverloaded(load, ms(4000)));
  EXPECT_FALSE(isOverloaded(load, ms(6000))) << "nobody has worked since";
  work(load, 0.5, 6000);
  EXPECT_FALSE(isOverloaded(load, ms(8000)));
}

// However often it is told.
TEST(Load, SmoothsWhatAViewerCosts) {
  for (const int64_t every_ms : {10, 50, 200}) {
    double cost = 0;
    const Duration spent = Duration::milliseconds(every_ms / 10), elapsed = Duration::milliseconds(every_ms);
    for (int64_t t = 0; t < Load::kCostMemory.toMilliseconds(); t += every_ms)
      cost = Load::costAfter(cost, spent, elapsed);
    EXPECT_NEAR(cost, 0.1 * (1 - std::exp(-1)), 1e-9) << every_ms;
  }
}

TEST(Load, GivesAWeightByWhatIsLeft) {
  Load load(2);
  EXPECT_EQ(Load::weightPercent(load.busyAt(ms(0))), 100);
  work(load, 0.425, 0);
  EXPECT_NEAR(Load::weightPercent(load.busyAt(ms(2000))), 50, 8);
  EXPECT_EQ(Load::weightPercent(load.busyAt(ms(4000))), 100) << "nobody has worked since";
  work(load, 1, 4000);
  EXPECT_EQ(Load::weightPercent(load.busyAt(ms(6000))), 1) << "0 would be no server at all";
}

TEST(Load, TakesOcclusionFromViewersAsItRisesAndGivesItBackAsItFalls) {
  Load load(2);
  EXPECT_EQ(load.occlusionShare(), 1);
  work(load, 0.4, 0);
  EXPECT_EQ(load.occlusionShare(), 1);
  work(load, 0.6, 2000);
  const double crowded = load.occlusionShare();
  EXPECT_LT(crowded, 0.5);
  work(load, 0.9, 4000);
  EXPECT_EQ(load.occlusionShare(), 0);
  work(load, 0.1, 6000);
  EXPECT_GT(load.occlusionShare(), 0.2);
  work(load, 0.1, 8000);
  work(load, 0.1, 10'000);
  EXPECT_EQ(load.occlusionShare(), 1);
}

TEST(Load, TakesOcclusionFromViewersWhileKeyframesWait) {
  Load load(1);
  for (int64_t t = 0; t < 2000; t += 250) {
    load.addWait(Load::kMaxWait + Duration::milliseconds(1));
    load.add(Duration::milliseconds(10), ms(t));
  }
  EXPECT_LT(load.occlusionShare(), 0.3);
}

TEST(Load, ExpectsSomethingOfNewViewers) {
  Load load(1);
  for (int i = 0; i < 20; ++i) load.addViewer();
  EXPECT_EQ(load.occlusionShare(), 1) << "there is room for so many";
  for (int i = 0; i < 40; ++i) load.addViewer();
  EXPECT_EQ(load.occlusionShare(), 0);
}

// By the time that the test gives it: what ran counts, whatever the time was.
TEST(ProcessorUse, IsTheShareOfTimeInWhichTheThreadRan) {
  ProcessorUse use;
  use.update(ms(0));
  const auto used_ms = [] {
    timespec time{};
    ::clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
    return time.tv_sec * 1000 + time.tv_nsec / 1'000'000;
  };
  const auto begin = used_ms();
  while (used_ms() < begin + 40) {}
  use.update(ms(20));
  EXPECT_EQ(use.thread().last(), 1);
  EXPECT_NEAR(use.thread().mean(), 1 - std::exp(-0.01), 1e-9);
  EXPECT_GT(use.process().last(), 0);
  use.update(ms(1'000'000));
  EXPECT_LT(use.thread().last(), 0.5);
  EXPECT_NEAR(use.thread().mean(), use.thread().last(), 1e-9);
  EXPECT_LT(use.process().last(), 0.5);
}

// As the kernel shows them, in files of a folder: the least of all groups above a process.
TEST(ProcessorQuota, IsTheLeastOfTheControlGroups) {
  const test::TemporaryFolder folder;
  const std::filesystem::path root = folder / "groups";
  const auto write = [&](const std::filesystem::path& file, const char* text) {
    std::filesystem::create_directories((root / file).parent_path());
    std::ofstream(root / file) << text;
  };
  EXPECT_FALSE(processorQuota(root, "/a/b"));
  write("a/b/cpu.max", "max 100000\n");
  EXPECT_FALSE(processorQuota(root, "/a/b"));
  write("a/cpu.max", "50000 100000\n");
  EXPECT_EQ(processorQuota(root, "/a/b"), 0.5);
  EXPECT_EQ(processorQuota(root, "/a/unknown/here"), 0.5);
  write("a/b/cpu.max", "20000 100000\n");
  EXPECT_EQ(processorQuota(root, "/a/b"), 0.2);
  write("cpu.cfs_quota_us", "-1\n"), write("cpu.cfs_period_us", "100000\n");
  EXPECT_EQ(processorQuota(root, "/a/b"), 0.2);
  write("cpu.cfs_quota_us", "10000\n");
  EXPECT_EQ(processorQuota(root, "/a/b"), 0.1);
  EXPECT_EQ(processorQuota(root, "/../../elsewhere"), 0.1);
  write("a/b/cpu.max", "nonsense");
  EXPECT_EQ(processorQuota(root, "/a/b"), 0.1);
}

}  // namespace
}  // namespace foreland::server
