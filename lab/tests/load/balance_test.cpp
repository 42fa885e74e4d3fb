// Where viewers are placed among servers, and which of them are moved.
#include "lab/load/balance.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>

#include "tests/support/seed.h"

namespace foreland::lab {
namespace {

struct Fleet {
  std::vector<ServerLoad> servers;
  std::vector<ViewerLoad> viewers;

  double difference() const {
    double least = 1e9, most = 0;
    for (const ServerLoad& s : servers)
      if (s.is_open) least = std::min(least, s.used), most = std::max(most, s.used);
    return most - least;
  }
};

Fleet randomFleet(Rng& rng) {
  Fleet fleet;
  fleet.servers.resize(2 + rng.below(6));
  for (ServerLoad& s : fleet.servers) s.is_open = rng.below(5) != 0;
  for (size_t i = rng.below(60); i > 0; --i) {
    fleet.viewers.push_back({rng.below(fleet.servers.size()), rng.uniform(0, 0.4), rng.below(4) != 0});
    fleet.servers[fleet.viewers.back().server].used += fleet.viewers.back().used;
  }
  return fleet;
}

TEST(Balance, PlacesViewersOnServersThatTakeThem) {
  Rng rng(test::randomSeed());
  for (int round = 0; round < 2000; ++round) {
    const Fleet fleet = randomFleet(rng);
    const bool any =
        std::any_of(fleet.servers.begin(), fleet.servers.end(), [](const ServerLoad& s) { return s.is_open; });
    for (const std::string& how : balanceNames()) {
      const auto server = placeViewer(*balanceNamed(how), fleet.servers, rng.below(100), rng);
      ASSERT_EQ(server.has_value(), any) << how;
      ASSERT_TRUE(!server || fleet.servers[*server].is_open) << how;
    }
  }
}

TEST(Balance, TakesTurnsOrTheLeastUsed) {
  Rng rng(1);
  const std::vector<ServerLoad> servers{{true, 0.5}, {false, 0}, {true, 0.2}, {true, 0.9}};
  for (size_t turn = 0; turn < 9; ++turn)
    EXPECT_EQ(placeViewer(Balance::kRoundRobin, servers, turn, rng), (std::array<size_t, 3>{0, 2, 3})[turn % 3]);
  EXPECT_EQ(placeViewer(Balance::kLeastLoaded, servers, 0, rng), 2u);
  EXPECT_EQ(placeViewer(Balance::kMigrate, servers, 0, rng), 2u);
  for (int i = 0; i < 100; ++i) EXPECT_NE(placeViewer(Balance::kTwoChoices, servers, 0, rng), 3u);
}

// So moving ends, and nobody is sent to and fro.
TEST(Balance, MovesOnlyMakeServersMoreEven) {
  Rng rng(test::randomSeed());
  size_t moves = 0;
  for (int round = 0; round < 500; ++round) {
    Fleet fleet = randomFleet(rng);
    size_t steps = 0;
    for (auto move = moveToMake(fleet.servers, fleet.viewers); move; move = moveToMake(fleet.servers, fleet.viewers)) {
      ViewerLoad& v = fleet.viewers[move->viewer];
      ASSERT_TRUE(v.is_movable);
      ASSERT_TRUE(fleet.servers[move->to].is_open);
      ServerLoad &from = fleet.servers[v.server], &to = fleet.servers[move->to];
      const double before = std::max(from.used, to.used), range = fleet.difference();
      ASSERT_NE(&from, &to);
      from.used -= v.used, to.used += v.used;
      v.server = move->to;
      ASSERT_LT(std::max(from.used, to.used), before);
      ASSERT_LE(fleet.difference(), range + 1e-12);
      ASSERT_LT(++steps, 10'000u);
    }
    moves += steps;
  }
  EXPECT_GT(moves, 100u);
}

TEST(Balance, MovesTheCostliestThatHelps) {
  const std::vector<ServerLoad> servers{{true, 0.8}, {true, 0.4}};
  const std::vector<ViewerLoad> viewers{{0, 0.1, true}, {0, 0.19, true}, {0, 0.21, true}, {0, 0.2, false}};
  const auto move = moveToMake(servers, viewers);
  ASSERT_TRUE(move);
  EXPECT_EQ(move->viewer, 1u);
  EXPECT_EQ(move->to, 1u);
}

TEST(Balance, LeavesIdleServersAlone) {
  const std::vector<ViewerLoad> viewers{{0, 0.01, true}};
  EXPECT_FALSE(moveToMake(std::vector<ServerLoad>{{true, 0.65}, {true, 0}}, viewers));
  EXPECT_FALSE(moveToMake(std::vector<ServerLoad>{{true, 0.9}, {true, 0.87}}, viewers));
  EXPECT_FALSE(moveToMake(std::vector<ServerLoad>{{true, 0.9}, {false, 0}}, viewers));
  EXPECT_FALSE(moveToMake(std::vector<ServerLoad>{{true, 0.9}, {true, 0, true}}, viewers));
  EXPECT_TRUE(moveToMake(std::vector<ServerLoad>{{true, 0.9}, {true, 0}}, viewers));
}

TEST(Balance, LeavesViewersAloneWhoTakeLongToResume) {
  const std::vector<ServerLoad> servers{{true, 0.9}, {true, 0.4}};
  EXPECT_FALSE(moveToMake(servers, std::vector<ViewerLoad>{{0, 0.1, true, 1.5 * kLongestResume_s}}));
  EXPECT_TRUE(moveToMake(servers, std::vector<ViewerLoad>{{0, 0.1, true, 0.5 * kLongestResume_s}}));
}

// Whatever the work, those who resume take no more than half of what is left.
TEST(ResumePace, LeavesTimeForTheOthers) {
  Rng rng(test::randomSeed());
  for (int round = 0; round < 100; ++round) {
    ResumePace pace;
    const double spare = rng.uniform(0.1, 2);
    Time now;
    Duration taken;
    for (int i = 0; i < 200; ++i) {
      for (; pace.isPausing(now); now = now + Duration::milliseconds(1)) {}
      const Duration work = Duration::seconds(rng.uniform(0.001, 0.2));
      pace.take(work, spare, now);
      taken = taken + work;
    }
    for (; pace.isPausing(now); now = now + Duration::milliseconds(1)) {}
    EXPECT_LE(taken.toSeconds(), 0.5 * spare * now.toSeconds() + 1e-3);
    EXPECT_GE(taken.toSeconds(), 0.4 * spare * now.toSeconds());
  }
}

}  // namespace
}  // namespace foreland::lab
