#include "server/session/migration.h"

#include <gtest/gtest.h>

#include "base/rng.h"
#include "tests/support/seed.h"

namespace foreland::server {
namespace {

TEST(MigrationTurns, FollowEachOtherAtEvenDistancesWithinHalfOfTheTime) {
  const uint64_t seed = test::randomSeed();
  SCOPED_TRACE("seed " + std::to_string(seed));
  Rng rng(seed);
  for (int i = 0; i < 200; ++i) {
    const size_t viewers = rng.below(500);
    const Time begin = Time::seconds(rng.uniform(-100, 100));
    const Duration most = Duration::seconds(rng.uniform(0, 20));
    const MigrationTurns turns(viewers, begin, most);
    EXPECT_EQ(turns.timeOf(0), begin);
    for (size_t turn = 0; turn < viewers + 3; ++turn) {
      EXPECT_LE(turns.timeOf(turn), turns.timeOf(turn + 1));
      EXPECT_LE(turns.timeOf(turn + 1) - turns.timeOf(turn), MigrationTurns::kBetweenViewers);
      EXPECT_LE((turns.timeOf(turn) - begin).us, most.us / 2);
    }
  }
}

TEST(Migration, LeavesOnceAllIsSentOrAfterASecond) {
  Migration migration;
  const Time asked = Time::seconds(5);
  EXPECT_FALSE(migration.leavesOnceSent());
  EXPECT_FALSE(migration.isOverdue(Time::seconds(1e6), false)) << "it was not asked";
  migration.ask(asked);
  migration.ask(asked + Duration::milliseconds(900));
  EXPECT_TRUE(migration.leavesOnceSent());
  EXPECT_FALSE(migration.isOverdue(asked + Migration::kLongest - Duration{1}, true));
  EXPECT_TRUE(migration.isOverdue(asked + Migration::kLongest, true));
  EXPECT_TRUE(migration.isOverdue(asked, false)) << "who has not said hello has nothing to wait for";
}

}  // namespace
}  // namespace foreland::server
