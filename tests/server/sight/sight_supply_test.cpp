#include "server/sight/sight_supply.h"

#include <gtest/gtest.h>

#include <atomic>
#include <thread>
#include <vector>

#include "tests/support/scene.h"

namespace foreland::server {
namespace {

TEST(SightSupply, OfTheCallerIsThereAtOnce) {
  const Hierarchy hierarchy(test::makeScene(60, 50, 3));
  SightSupply supply(hierarchy);
  const auto made = supply.ask();
  ASSERT_TRUE(made.ok());
  ASSERT_NE(*made, nullptr);
  EXPECT_EQ(*supply.ask(), *made);
}

TEST(SightSupply, OnAThreadIsMadeOnceForAllWhoAsk) {
  const Hierarchy hierarchy(test::makeScene(60, 50, 3));
  SightSupply supply(hierarchy, SightSupply::Building::kOnAThread);
  std::vector<std::shared_ptr<const SightScene>> made(4);
  {
    std::vector<std::jthread> askers;
    for (auto& mine : made)
      askers.emplace_back([&] {
        while (!mine) {
          const auto asked = supply.ask();
          ASSERT_TRUE(asked.ok());
          mine = *asked;
          std::this_thread::yield();
        }
      });
  }
  for (const auto& each : made) EXPECT_EQ(each, made[0]);
}

TEST(SightSupply, SaysWhyThereIsNone) {
  const Hierarchy hierarchy(test::makeScene(60, 50, 3));
  SightSupply off(hierarchy, SightSupply::Building::kOnAThread, {0}),
      small(hierarchy, SightSupply::Building::kByTheCaller, {1000});
  ASSERT_FALSE(off.ask().ok());
  EXPECT_NE(off.ask().error().message.find("--sight-memory-mib"), std::string::npos);
  ASSERT_FALSE(small.ask().ok());
  EXPECT_EQ(small.ask().error().code, ErrorCode::kLimit);
}

}  // namespace
}  // namespace foreland::server
