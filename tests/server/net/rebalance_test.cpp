// A server that is overloaded asks as many viewers to leave as it must, not more, and does not send them round and
// round.
#include "server/net/rebalance.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <numeric>

#include "base/rng.h"
#include "tests/support/seed.h"

namespace foreland::server {
namespace {

using Viewer = Rebalance::Viewer;

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

TEST(Rebalance, AsksNobodyUnlessItIsOverloaded) {
  Rng rng(test::randomSeed());
  EXPECT_TRUE(Rebalance().choose(someViewers(rng), 0.8, false, 1, at(100)).empty());
}

// The least number of viewers that will do, by trying them all in the order of what they cost.
TEST(Rebalance, AsksTheFewestThatSuffice) {
  Rng rng(test::randomSeed());
  for (int i = 0; i < 200; ++i) {
    const std::vector<Viewer> viewers = someViewers(rng);
    const double load = rng.uniform(0.86, 1), excess = load - Rebalance::kGoal;
    const auto asked = Rebalance().choose(viewers, load, true, 1, at(100));
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
  for (const size_t i : Rebalance().choose(viewers, 1, true, 1, at(100))) EXPECT_EQ(i % 2, 1u);
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
      auto asked = servers[s].choose(of[s], 1, true, 1, at(second));
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
  for (int i = 0; i < 8; ++i, now += 61) EXPECT_FALSE(server.choose(viewers, 1, true, 1, at(now)).empty());
  EXPECT_TRUE(server.choose(viewers, 1, true, 1, at(now - 30)).empty());
  EXPECT_TRUE(server.choose(viewers, 0.5, false, 1, at(now)).empty());
  EXPECT_FALSE(server.choose(viewers, 1, true, 1, at(now + 1)).empty());
  EXPECT_FALSE(server.choose(viewers, 1, true, 1, at(now + 3.1)).empty());
}

}  // namespace
}  // namespace foreland::server
