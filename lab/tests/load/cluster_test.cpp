// Several servers in virtual time, which fail, drain and join, and viewers who resume on another.
#include "lab/load/cluster.h"

#include <gtest/gtest.h>

#include "lab/load/experiment.h"
#include "tests/support/scene.h"
#include "tests/support/seed.h"

namespace foreland::lab {
namespace {

using What = ServerEvent::What;

std::shared_ptr<const server::World> smallWorld() {
  static const auto world = std::make_shared<server::World>(test::makeScene(129, 129, 5));
  return world;
}

// Every keyframe costs 4 ms.
LoadOptions smallCluster(size_t viewers, Balance balance, std::vector<ServerEvent> events) {
  LoadOptions options;
  options.viewers = viewers;
  options.seconds = 4;
  options.tau_px = 20;
  options.start = LoadStart::kEarly;
  options.prices = {"test", 4e6, 0, 0, 0, 0, 0};
  options.seed = test::randomSeed();
  options.cluster = {3, balance, std::move(events)};
  return options;
}

LoadRun run(const LoadOptions& options) { return runLoad(smallWorld(), options); }

TEST(Cluster, ServesEveryoneInTimeWhileNothingHappens) {
  const LoadRun result = run(smallCluster(12, Balance::kRoundRobin, {}));
  const ClusterFigures& f = result.cluster->figures;
  EXPECT_EQ(f.asked, 12u * 5 * 4);
  EXPECT_LT(f.not_in_time_share, 0.05);
  EXPECT_TRUE(result.cluster->moves.empty());
  for (const ServerLook& look : result.cluster->looks) EXPECT_EQ(look.viewers, 4u);
}

TEST(Cluster, ResumesTheViewersOfAServerThatFails) {
  for (const std::string& how : balanceNames()) {
    const LoadRun result = run(smallCluster(15, *balanceNamed(how), {{What::kFail, 1, 1.2}}));
    const ClusterFigures& f = result.cluster->figures;
    EXPECT_EQ(f.afresh, 0u) << how;
    uint64_t there = 0;  // by chance it may have none
    for (const ServerLook& look : result.cluster->looks)
      if (look.server == 1 && look.time_s < 1.2) there = look.viewers;
    EXPECT_EQ(f.lost, there) << how;
    EXPECT_LT(f.lost_gap_max_ms, 1500) << how;
    for (const ServerLook& look : result.cluster->looks)
      EXPECT_TRUE(look.server != 1 || look.time_s < 1.6 || (look.viewers == 0 && look.used == 0)) << how;
  }
}

TEST(Cluster, HandsViewersOverWithoutLosingWhatTheyHold) {
  const LoadRun result = run(smallCluster(15, Balance::kLeastLoaded, {{What::kDrain, 0, 1}}));
  const ClusterFigures& f = result.cluster->figures;
  EXPECT_GT(f.migrated, 0u);
  EXPECT_EQ(f.lost + f.afresh, 0u);
  EXPECT_LT(f.move_gap_max_ms, 900);
  EXPECT_GT(f.move_up_mean, 0);
  EXPECT_EQ(result.cluster->looks.back().time_s, result.cluster->looks[result.cluster->looks.size() - 3].time_s);
  EXPECT_EQ(result.cluster->looks[result.cluster->looks.size() - 3].viewers, 0u);
}

// Whoever places viewers only when they come leaves a new server idle.
TEST(Cluster, MovesViewersToAServerThatJoins) {
  const auto viewersAtTheEnd = [](Balance balance) {
    LoadOptions options = smallCluster(18, balance, {{What::kJoin, 2, 0.5}});
    options.prices.keyframe = 20e6;  // so that two workers are nearly full
    options.seconds = 8;
    const LoadRun result = run(options);
    EXPECT_EQ(result.cluster->figures.afresh, 0u);
    return result.cluster->looks.back();
  };
  EXPECT_EQ(viewersAtTheEnd(Balance::kLeastLoaded).viewers, 0u);
  const ServerLook joined = viewersAtTheEnd(Balance::kMigrate);
  EXPECT_EQ(joined.server, 2u);
  EXPECT_GT(joined.viewers, 2u);
}

TEST(Cluster, NeverCountsMoreInTimeThanWereAskedFor) {
  for (const size_t viewers : {5, 20, 60}) {
    LoadOptions options = smallCluster(viewers, Balance::kMigrate, {{What::kFail, 0, 1}, {What::kJoin, 0, 2}});
    options.prices.keyframe = 20e6;
    const LoadRun result = run(options);
    const ClusterFigures& f = result.cluster->figures;
    EXPECT_LE(f.not_in_time, f.asked);
    for (const double used : result.used) EXPECT_LE(used, 1 + 1e-9);
    EXPECT_TRUE(viewers < 60 || f.not_in_time_share > 0.3);  // twice what three workers can do
  }
}

TEST(Cluster, GivesTheSameFilesInEveryRun) {
  LoadRequest request;
  request.base = smallCluster(12, Balance::kRandom, {});
  request.fails = {"2@1"};
  request.joins = {"2@2.5"};
  const auto runs = runsOf(request);
  ASSERT_TRUE(runs.ok()) << runs.error().message;
  ASSERT_EQ(runs->size(), 5u);
  const auto filesOf = [&](unsigned threads) {
    const test::TemporaryFolder folder;
    const auto tables = runAll(smallWorld(), *runs, {}, {}, threads, [](size_t) {});
    EXPECT_TRUE(writeCells(folder / "out", {{"seed", 1}}, kLoadNames, tables.value()).ok());
    std::vector<std::vector<char>> files;
    for (const char* name : {"results.csv", "servers.csv", "in_time.csv", "moves.csv"})
      files.push_back(test::slurp(folder / ("out/" + std::string(name))));
    return files;
  };
  const auto one = filesOf(1);
  for (const auto& file : one) EXPECT_GT(file.size(), 300u);
  EXPECT_EQ(one, filesOf(2));
}

TEST(Cluster, RefusesServersThatMakeNoSenseByName) {
  const auto refusal = [](LoadRequest request) {
    const auto runs = runsOf(request);
    return runs.ok() ? std::string() : runs.error().message;
  };
  LoadRequest three;
  three.base.cluster.servers = 3;
  const auto with = [&](auto change) {
    LoadRequest request = three;
    change(request);
    return refusal(request);
  };
  EXPECT_EQ(refusal(three), "");
  EXPECT_NE(with([](LoadRequest& r) { r.fails = {"4@1"}; }).find("no server 4"), std::string::npos);
  EXPECT_NE(with([](LoadRequest& r) { r.fails = {"0@1"}; }).find("'0@1'"), std::string::npos);
  EXPECT_NE(with([](LoadRequest& r) { r.drains = {"soon"}; }).find("'soon'"), std::string::npos);
  EXPECT_NE(with([](LoadRequest& r) { r.joins = {"1@nan"}; }).find("'1@nan'"), std::string::npos);
  EXPECT_NE(with([](LoadRequest& r) { r.joins = {"1@99"}; }).find("server 1"), std::string::npos);
  EXPECT_NE(with([](LoadRequest& r) { r.joins = {"1@1", "2@1", "3@1"}; }).find("at least one"), std::string::npos);
  EXPECT_NE(with([](LoadRequest& r) { r.balances = {"luck"}; }).find("'luck'"), std::string::npos);
  LoadRequest one;
  one.fails = {"1@1"};
  EXPECT_NE(refusal(one).find("--servers"), std::string::npos);
}

}  // namespace
}  // namespace foreland::lab
