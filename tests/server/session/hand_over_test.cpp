#include "server/session/hand_over.h"

#include <gtest/gtest.h>

#include "base/rng.h"
#include "tests/support/seed.h"

namespace foreland::server {
namespace {

TEST(HandOverTurns, FollowEachOtherAtEvenDistancesWithinHalfOfTheTime) {
  const uint64_t seed = test::randomSeed();
  SCOPED_TRACE("seed " + std::to_string(seed));
  Rng rng(seed);
  for (int i = 0; i < 200; ++i) {
    const size_t viewers = rng.below(500);
    const Time begin = Time::seconds(rng.uniform(-100, 100));
    const Duration most = Duration::seconds(rng.uniform(0, 20));
    const HandOverTurns turns(viewers, begin, most);
    EXPECT_EQ(turns.timeOf(0), begin);
    for (size_t turn = 0; turn < viewers + 3; ++turn) {
      EXPECT_LE(turns.timeOf(turn), turns.timeOf(turn + 1));
      EXPECT_LE(turns.timeOf(turn + 1) - turns.timeOf(turn), HandOverTurns::kBetweenViewers);
      EXPECT_LE((turns.timeOf(turn) - begin).us, most.us / 2);
    }
  }
}

TEST(HandOver, LeavesOnceAllIsSentOrAfterASecond) {
  HandOver hand_over;
  const Time asked = Time::seconds(5);
  EXPECT_FALSE(hand_over.leavesOnceSent());
  EXPECT_FALSE(hand_over.isOverdue(Time::seconds(1e6), false)) << "it was not asked";
  hand_over.ask(asked);
  hand_over.ask(asked + Duration::milliseconds(900));
  EXPECT_TRUE(hand_over.leavesOnceSent());
  EXPECT_FALSE(hand_over.isOverdue(asked + HandOver::kLongest - Duration{1}, true));
  EXPECT_TRUE(hand_over.isOverdue(asked + HandOver::kLongest, true));
  EXPECT_TRUE(hand_over.isOverdue(asked, false)) << "who has not said hello has nothing to wait for";
}

}  // namespace
}  // namespace foreland::server
