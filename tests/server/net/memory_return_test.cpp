// When memory goes back to the system.
#include "server/net/memory_return.h"

#include <gtest/gtest.h>

namespace foreland::server {
namespace {

TEST(MemoryReturn, IsDueWhenAQuarterOfTheViewersHaveLeft) {
  MemoryReturn memory;
  Time now = Time::seconds(100);
  const auto isDue = [&](size_t viewers) { return memory.isDue(viewers, now = now + MemoryReturn::kMinInterval); };
  EXPECT_FALSE(isDue(0)) << "nobody was there";
  EXPECT_FALSE(isDue(8));
  EXPECT_FALSE(isDue(7));
  EXPECT_TRUE(isDue(6));
  EXPECT_FALSE(isDue(6));
  EXPECT_FALSE(isDue(5));
  EXPECT_TRUE(isDue(4));
  EXPECT_FALSE(isDue(100));
  EXPECT_TRUE(isDue(0));
  EXPECT_FALSE(isDue(0)) << "all of it has been returned";
  EXPECT_FALSE(isDue(1));
  EXPECT_TRUE(isDue(0)) << "the only one has left";
}

TEST(MemoryReturn, IsNotDueOften) {
  MemoryReturn memory;
  Time now = Time::seconds(100);
  memory.isDue(10, now);
  EXPECT_TRUE(memory.isDue(5, now));
  memory.isDue(10, now);
  EXPECT_FALSE(memory.isDue(5, now + MemoryReturn::kMinInterval - Duration{1}));
  EXPECT_TRUE(memory.isDue(5, now + MemoryReturn::kMinInterval));
}

}  // namespace
}  // namespace foreland::server
