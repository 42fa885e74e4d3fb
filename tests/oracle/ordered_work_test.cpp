#include "oracle/ordered_work.h"

#include <gtest/gtest.h>

#include <atomic>
#include <latch>
#include <vector>

namespace foreland::oracle {
namespace {

using Work = OrderedWork<int, int>;

TEST(OrderedWork, GivesResultsInTheOrderOfPiecesWithAnyNumberOfWorkers) {
  for (const unsigned workers : {1u, 2u, 5u}) {
    std::vector<int> taken;
    Work work(
        workers, [](const int& piece, unsigned) { return 2 * piece; }, [&](int result) { taken.push_back(result); });
    for (int i = 0; i < 300; ++i) work.add(i);
    work.finish();
    ASSERT_EQ(taken.size(), 300u) << workers;
    for (int i = 0; i < 300; ++i) ASSERT_EQ(taken[static_cast<size_t>(i)], 2 * i) << workers;
  }
}

// The first piece ends only after the second one has.
TEST(OrderedWork, KeepsWhatIsDoneEarlyUntilItsTurn) {
  std::latch second_is_done(1);
  std::vector<int> taken;
  const auto wait = [&](const int& piece, unsigned) {
    if (piece == 0) second_is_done.wait();
    if (piece == 1) second_is_done.count_down();
    return piece;
  };
  Work work(2, wait, [&](int result) { taken.push_back(result); });
  for (int i = 0; i < 3; ++i) work.add(i);
  work.finish();
  EXPECT_EQ(taken, (std::vector{0, 1, 2}));
}

TEST(OrderedWork, HoldsTwoPiecesForEachWorkerAtMost) {
  for (const unsigned workers : {1u, 3u}) {
    int added = 0, taken = 0, most = 0;
    Work work(
        workers, [](const int& piece, unsigned) { return piece; }, [&](int) { ++taken; });
    for (int i = 0; i < 200; ++i) {
      work.add(i);
      most = std::max(most, ++added - taken);
    }
    work.finish();
    EXPECT_LE(most, static_cast<int>(2 * workers));
    EXPECT_EQ(taken, 200);
  }
}

TEST(OrderedWork, GivesEachWorkerOnePieceAtATime) {
  constexpr unsigned kWorkers = 4;
  std::array<std::atomic<int>, kWorkers> busy{};
  std::atomic<bool> overlaps{false};
  Work work(
      kWorkers,
      [&](const int& piece, unsigned worker) {
        overlaps = overlaps || worker >= kWorkers || ++busy[worker % kWorkers] != 1;
        --busy[worker % kWorkers];
        return piece;
      },
      [](int) {});
  for (int i = 0; i < 500; ++i) work.add(i);
  work.finish();
  EXPECT_FALSE(overlaps);
}

TEST(OrderedWork, DropsWhatIsLeftWhenItEnds) {
  int taken = 0;
  {
    Work work(
        2, [](const int& piece, unsigned) { return piece; }, [&](int) { ++taken; });
    for (int i = 0; i < 50; ++i) work.add(i);
  }
  EXPECT_GE(taken, 46);  // 4 pieces may wait
  EXPECT_LE(taken, 50);
}

}  // namespace
}  // namespace foreland::oracle
