// A server that is overloaded, or busier than the others, asks as many viewers to leave as it must, not more, and does
// not send them round and round.
#include "server/net/rebalance.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "base/rng.h"
#include "server/net/fleet_level.h"
#include "server/net/metrics/load.h"
#include "tests/support/seed.h"

namespace foreland::server {
namespace {

using Viewer = Rebalance::Viewer;
constexpr Rebalance::Use kFull{.load = 1};

Time at(double seconds) { return Time{} + Duration::seconds(seconds); }

// Long ago.
std::vector<Viewer> someViewers(Rng& rng) {
  std::vector<Viewer> viewers(8 + rng.below(60));
  for (Viewer& viewer : viewers) viewer = {rng.uniform(0.001, 0.05), at(0)};
  return viewers;
}

double costOf(const std::vector<Viewer>& viewers, const std::vector<size_t>& which) {
  return std::accumulate(which.begin(), which.end(), 0.0, [&](double sum, size_t i) { return sum + viewers[i].cost; });
}

double sumOf(const std::vector<Viewer>& viewers) {
  return std::accumulate(viewers.begin(), viewers.end(), 0.0,
                         [](double sum, const Viewer& viewer) { return sum + viewer.cost; });
}

TEST(Rebalance, AsksNobodyUnlessItIsOverloaded) {
  Rng rng(test::randomSeed());
  EXPECT_TRUE(Rebalance().choose(someViewers(rng), {.load = 0.8}, at(100)).empty());
}

// The least number of viewers that will do, by trying them all in the order of what they cost.
TEST(Rebalance, AsksTheFewestThatSuffice) {
  Rng rng(test::randomSeed());
  for (int i = 0; i < 200; ++i) {
    std::vector<Viewer> viewers = someViewers(rng);
    const double load = rng.uniform(0.86, 1), excess = load - Rebalance::kGoal, sum = sumOf(viewers);
    for (Viewer& viewer : viewers) viewer.cost *= load / sum;
    const auto asked = Rebalance().choose(viewers, {.load = load}, at(100));
    ASSERT_FALSE(asked.empty());
    std::vector<double> costs;
    for (const Viewer& viewer : viewers) costs.push_back(viewer.cost);
    std::sort(costs.rbegin(), costs.rend());
    EXPECT_NEAR(costOf(viewers, asked),
                std::accumulate(costs.begin(), costs.begin() + static_cast<long>(asked.size()), 0.0), 1e-12);
    EXPECT_LT(costOf(viewers, asked) - viewers[asked.back()].cost, excess);
    EXPECT_TRUE(costOf(viewers, asked) >= excess || asked.size() == viewers.size() / 4) << asked.size();
  }
}

TEST(Rebalance, LetsThoseStayWhoHaveJustCome) {
  Rng rng(test::randomSeed());
  std::vector<Viewer> viewers = someViewers(rng);
  for (size_t i = 0; i < viewers.size(); ++i) viewers[i].since = at(i % 2 == 0 ? 95 : 5);
  for (const size_t i : Rebalance().choose(viewers, kFull, at(100))) EXPECT_EQ(i % 2, 1u);
}

// Two servers with too many for both: a viewer that has to leave comes to the other one.
TEST(Rebalance, DoesNotSendViewersRoundAndRoundWhereAllAreOverloaded) {
  Rng rng(test::randomSeed());
  std::vector<Viewer> of[2] = {someViewers(rng), someViewers(rng)};
  Rebalance servers[2];
  const size_t all = of[0].size() + of[1].size();
  size_t moves = 0;
  for (int second = 100; second < 700; ++second)
    for (size_t s = 0; s < 2; ++s) {
      auto asked = servers[s].choose(of[s], kFull, at(second));
      moves += asked.size();
      std::sort(asked.rbegin(), asked.rend());
      for (const size_t i : asked) {
        of[1 - s].push_back({of[s][i].cost, at(second)});
        of[s].erase(of[s].begin() + static_cast<long>(i));
      }
    }
  EXPECT_EQ(of[0].size() + of[1].size(), all);
  EXPECT_LT(static_cast<double>(moves) / static_cast<double>(all), 5) << "in ten minutes";
}

TEST(Rebalance, AsksQuicklyAgainOnceItHadRoom) {
  Rng rng(test::randomSeed());
  const std::vector<Viewer> viewers = someViewers(rng);
  Rebalance server;
  double now = 100;
  for (int i = 0; i < 8; ++i, now += 61) EXPECT_FALSE(server.choose(viewers, kFull, at(now)).empty());
  EXPECT_TRUE(server.choose(viewers, kFull, at(now - 30)).empty());
  EXPECT_TRUE(server.choose(viewers, {.load = 0.5}, at(now)).empty());
  EXPECT_FALSE(server.choose(viewers, kFull, at(now + 1)).empty());
  EXPECT_FALSE(server.choose(viewers, kFull, at(now + 3.1)).empty());
}

// Servers who know their mean, and viewers who come to one of them at random where they leave another: all are even
// soon, and nobody is moved any more. Costs differ tenfold.
TEST(Rebalance, BringsServersToOneLevelThatKnowIt) {
  Rng rng(test::randomSeed());
  for (int run = 0; run < 40; ++run) {
    constexpr size_t kServers = 4;
    std::vector<Viewer> of[kServers];
    double mean = 0;
    for (size_t s = 0; s < kServers; ++s) {
      const double use = rng.uniform(0.1, 1);
      while (sumOf(of[s]) < use) of[s].push_back({rng.uniform(0.002, 0.02), at(0)});
      mean += sumOf(of[s]) / kServers;
    }
    Rebalance servers[kServers];
    double last_move = 100;
    for (int second = 100; second < 300; ++second)
      for (size_t s = 0; s < kServers; ++s) {
        const double used = sumOf(of[s]);
        auto asked = servers[s].choose(of[s], {.load = used, .fleet = mean}, at(second));
        if (!asked.empty()) last_move = second;
        EXPECT_TRUE(asked.empty() || used > mean);
        std::sort(asked.rbegin(), asked.rend());
        for (const size_t i : asked) {
          const auto to = std::min_element(std::begin(of), std::end(of),
                                           [](const auto& a, const auto& b) { return sumOf(a) < sumOf(b); });
          to->push_back({of[s][i].cost, at(second)});
          of[s].erase(of[s].begin() + static_cast<long>(i));
        }
      }
    EXPECT_LE(last_move, 130);
    for (const auto& viewers : of) EXPECT_LE(sumOf(viewers), std::max(1.12 * mean, Rebalance::kLeast + 0.02));
  }
}

// However much one of them takes.
TEST(Rebalance, DoesNotGiveMoreThanIsAboveTheLevel) {
  Rng rng(test::randomSeed());
  size_t asked_in_all = 0;
  for (int i = 0; i < 500; ++i) {
    std::vector<Viewer> viewers = someViewers(rng);
    for (size_t k = 1 + rng.below(3); k > 0; --k) viewers[rng.below(viewers.size())].cost = rng.uniform(0.05, 0.5);
    const double used = sumOf(viewers), fleet = rng.uniform(0.3, 1) * used;
    const auto asked = Rebalance().choose(viewers, {.load = std::min(1.0, used), .fleet = fleet}, at(100));
    EXPECT_GE(used - costOf(viewers, asked), std::max(fleet, Rebalance::kLeast) - 1e-9) << asked.size();
    asked_in_all += asked.size();
  }
  EXPECT_GT(asked_in_all, 200u);
}

TEST(Rebalance, AsksNobodyWhereTheOthersAreAsBusy) {
  Rng rng(test::randomSeed());
  for (int i = 0; i < 200; ++i) {
    const std::vector<Viewer> viewers = someViewers(rng);
    const double used = sumOf(viewers);
    EXPECT_TRUE(Rebalance().choose(viewers, {.load = 1, .fleet = used / 1.05}, at(100)).empty());
  }
  EXPECT_TRUE(Rebalance().choose(std::vector<Viewer>(20, {0.01, at(0)}), {.load = 0.2, .fleet = 0.01}, at(100)).empty())
      << "who has time for all";
}

// Where viewers cost the workers next to nothing.
TEST(Rebalance, CountsTheThreadForConnections) {
  const std::vector<Viewer> viewers(60, {0.001, at(0)});
  const auto asked = [&](double connections) {
    return Rebalance().choose(viewers, {.connections = connections, .fleet = 0.5}, at(100)).size();
  };
  EXPECT_EQ(asked(0.5), 0u);
  EXPECT_EQ(asked(0.9), 2u);
  // 0.06 are too much, and each of three takes nearly a third of 0.56, so none of them can go.
  const std::vector<Viewer> three(3, {0.001, at(0)});
  EXPECT_TRUE(Rebalance().choose(three, {.connections = 0.56, .fleet = 0.5}, at(100)).empty());
}

// Six servers' weights as HAProxy 2.6 sends them.
TEST(FleetLevel, IsTheMeanThatWeightsSay) {
  FleetLevel level;
  EXPECT_FALSE(level.at(at(0)));
  level.note("UP 1/3; address=127.0.0.1; port=18081; name=ready/a; node=vm; weight=100/300; scur=0/0; qcur=0", "6",
             at(1));
  ASSERT_TRUE(level.at(at(1)));
  EXPECT_NEAR(*level.at(at(1)), 0.425, 1e-12);
  EXPECT_TRUE(level.at(at(6)));
  EXPECT_FALSE(level.at(at(6.1))) << "nobody says it any more";
}

TEST(FleetLevel, IsSmoothedHoweverOftenItIsSaid) {
  for (const double every : {0.1, 0.25, 1.0}) {
    FleetLevel level;
    level.note("UP; weight=100/200", "2", at(0));
    for (double t = every; t <= 2 + 1e-9; t += every) level.note("UP; weight=0/0", "2", at(t));
    EXPECT_NEAR(*level.at(at(2)), Load::kBusy * (1 - std::exp(-1)), 1e-6) << every;
  }
}

TEST(FleetLevel, IsOneWhereNoServerTakesViewers) {
  FleetLevel level;
  level.note("DOWN 0/1; name=ready/a; weight=100/0; scur=0/0; qcur=0", "0", at(0));
  EXPECT_EQ(level.at(at(0)), 1);
}

TEST(FleetLevel, DoesNotTakeWhatMakesNoSense) {
  for (const auto& [state, servers] :
       std::initializer_list<std::pair<const char*, const char*>>{{"", ""},
                                                                  {"UP; weight=1/2", ""},
                                                                  {"UP; weight=1/2", "x"},
                                                                  {"UP; weight=1/2", "-1"},
                                                                  {"UP; weight=1/2", "1 "},
                                                                  {"UP; weight=1", "1"},
                                                                  {"UP; weight=1/", "1"},
                                                                  {"UP; weight=1/x", "1"},
                                                                  {"UP; weight=1/201", "2"},
                                                                  {"weight=1/2", "2"},
                                                                  {"UP; weight=1/99999999999999999999999", "2"},
                                                                  {"UP; weight=1/2", "99999999999999999999999"},
                                                                  {"UP; weight=1/2", "18446744073709551615"}}) {
    FleetLevel level;
    level.note(state, servers, at(0));
    EXPECT_FALSE(level.at(at(0))) << state << " of " << servers;
  }
}

}  // namespace
}  // namespace foreland::server
