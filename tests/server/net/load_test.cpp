// When the workers count as too busy for further viewers, which /readyz tells.
#include "server/net/metrics/load.h"

#include <gtest/gtest.h>

namespace foreland::server {
namespace {

Time ms(int64_t t) { return Time{} + Duration::milliseconds(t); }

// Two workers, each busy for `share` of the time, from `begin` on for two seconds.
void work(Load& load, double share, int64_t begin_ms) {
  for (int64_t t = begin_ms; t < begin_ms + 2000; t += 50) load.add(Duration::seconds(0.05 * 2 * share), ms(t + 50));
}

TEST(Load, IsOverloadedWhileWorkersAreBusyAndNotLongAfter) {
  Load load(2);
  EXPECT_FALSE(load.isOverloaded(ms(0)));
  work(load, 0.5, 0);
  EXPECT_NEAR(load.busy(), 0.5, 0.06);
  EXPECT_FALSE(load.isOverloaded(ms(2000)));
  work(load, 0.97, 2000);
  EXPECT_TRUE(load.isOverloaded(ms(4000)));
  EXPECT_FALSE(load.isOverloaded(ms(6000))) << "nobody has worked since";
  work(load, 0.5, 6000);
  EXPECT_FALSE(load.isOverloaded(ms(8000)));
}

}  // namespace
}  // namespace foreland::server
