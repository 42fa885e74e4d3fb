#include "server/session/input/announced_jumps.h"

#include <gtest/gtest.h>

#include <deque>

#include "base/rng.h"
#include "tests/support/seed.h"

namespace foreland::server {
namespace {

// Whenever they are announced: in any period, as many as at once and one for each of its seconds.
TEST(AnnouncedJumps, AreTakenAtTheirRateAtMost) {
  const uint64_t seed = test::randomSeed();
  SCOPED_TRACE("seed " + std::to_string(seed));
  Rng rng(seed);
  AnnouncedJumps jumps;
  std::deque<Time> taken;
  for (Time now = Time::seconds(-5); now < Time::seconds(200); now.us += static_cast<int64_t>(rng.below(300'000))) {
    if (rng.below(40) == 0) now = now + Duration::seconds(rng.uniform(0, 6));
    if (!jumps.take(now)) continue;
    taken.push_back(now);
    for (size_t i = 0; i < taken.size(); ++i)
      EXPECT_LE(int64_t(taken.size() - i) - AnnouncedJumps::kAtOnce, (now - taken[i]).us / AnnouncedJumps::kEvery.us);
  }
  EXPECT_GT(taken.size(), 150u) << "nor fewer";
}

TEST(AnnouncedJumps, AreAllTakenOfWhoAnnouncesFew) {
  AnnouncedJumps jumps;
  for (int i = 0; i < 50; ++i) EXPECT_TRUE(jumps.take(Time{} + AnnouncedJumps::kEvery * i)) << i;
  for (int i = 0; i < 4; ++i) EXPECT_TRUE(jumps.take(Time::seconds(1000))) << i;
  EXPECT_FALSE(jumps.take(Time::seconds(1000)));
}

}  // namespace
}  // namespace foreland::server
