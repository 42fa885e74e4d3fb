// Many viewers on few processors in virtual time.
#include <gtest/gtest.h>

#include <map>
#include <numeric>

#include "lab/load/experiment.h"
#include "lab/load/load_cast.h"
#include "tests/support/scene.h"

namespace foreland::lab {
namespace {

std::shared_ptr<const server::World> smallWorld() {
  static const auto world = std::make_shared<server::World>(test::makeScene(129, 129, 5));
  return world;
}

// Every keyframe costs 4 ms, so that one worker serves 250 a second, 50 viewers.
LoadOptions smallLoad(size_t viewers) {
  LoadOptions options;
  options.viewers = viewers;
  options.seconds = 2;
  options.tau_px = 20;
  options.mix = Mix::kSurvey;
  options.prices = {"test", 4e6, 0, 0, 0, 0, 0, 0};
  return options;
}

LoadFigures run(LoadOptions options) { return runLoad(smallWorld(), options).figures; }

TEST(Load, ServesAFewViewersInTime) {
  const LoadFigures f = run(smallLoad(4));
  EXPECT_NEAR(static_cast<double>(f.keyframes), 4 * 5 * 2, 4);
  EXPECT_NEAR(f.utilisation, 0.08, 0.01);
  EXPECT_NEAR(f.work_mean_ms, 4, 1e-9);
  EXPECT_GT(f.jain, 0.9);
}

TEST(Load, NeverUsesMoreThanAllOfItsWorkers) {
  for (const size_t workers : {1, 3}) {
    LoadOptions options = smallLoad(120);
    options.workers = workers;
    const LoadRun result = runLoad(smallWorld(), options);
    for (const double used : result.used) EXPECT_LE(used, 1 + 1e-9);
    EXPECT_GT(result.figures.utilisation, workers == 1 ? 0.95 : 0.7);
    EXPECT_EQ(result.figures.keyframes, result.lateness_ms.size());
  }
}

// The finding of issue 15: viewers who are due together are late though the worker idles before, unless their keyframes
// are begun early.
TEST(Load, MissesDeadlinesTogetherUnlessItStartsEarly) {
  LoadOptions options = smallLoad(20);  // two fifths of the worker
  options.phases = Phases::kSynchronised;
  EXPECT_GT(run(options).missed_share, 0.5);
  options.start = LoadStart::kEarly;
  EXPECT_LT(run(options).missed_share, 0.02);
  options.phases = Phases::kStaggered;
  EXPECT_LT(run(options).missed_share, 0.02);
}

TEST(Load, CountsWhatIsDueAtOnceApart) {
  LoadOptions options = smallLoad(20);
  options.mix = Mix::kMixed;  // one of them jumps
  options.seconds = 9;
  const LoadFigures f = run(options);
  EXPECT_GE(f.at_once, 2u);
  EXPECT_LE(f.at_once, 4u);
}

// A keyframe that costs more than its session expects is late though the worker idles, unless it is begun sooner.
TEST(Load, MeetsDeadlinesWithSlackThatCostsFreshness) {
  LoadOptions options = smallLoad(1);
  options.start = LoadStart::kEarly;
  options.seconds = 20;
  options.prices = {"test", 1e6, 0, 0, 0, 0, 20'000, 0};  // a keyframe costs now more, now less
  options.slack_ms = 0;
  const LoadFigures tight = run(options);
  options.slack_ms = 10;
  const LoadFigures slack = run(options);
  EXPECT_GT(tight.missed, 0u);
  EXPECT_EQ(slack.missed, 0u);
  EXPECT_NEAR(slack.ahead_mean_ms, tight.ahead_mean_ms + 10, 1);
}

// What is measured does not get longer or shorter with the time before.
TEST(Load, MeasuresForAsLongAfterAnyRunIn) {
  for (const double run_in_s : {2.0, 3.0, 12.0}) {
    LoadOptions options = smallLoad(4);
    options.run_in_s = run_in_s;
    const LoadRun result = runLoad(smallWorld(), options);
    EXPECT_NEAR(static_cast<double>(result.figures.keyframes), 4 * 5 * 2, 4) << run_in_s;
    EXPECT_EQ(result.used.size(), 100u);
  }
}

// What is hidden costs time to find out, and is told apart from the rest.
TEST(Load, PricesWhatOcclusionTests) {
  const auto hidden = [](bool occlusion) {
    auto world = std::make_shared<server::World>(test::makeScene(257, 257, 5));
    world->occlusion = server::SceneOcclusion::create(world->hierarchy).value();
    LoadOptions options = smallLoad(3);
    options.tau_px = 2;
    options.occlusion = occlusion ? server::Occlusion::kOn : server::Occlusion::kOff;
    options.prices = {"test", 4e6, 0, 0, 0, 0, 0, 0, 1e4, 1e4, 1e4};
    return runLoad(world, options).figures.shares.back();
  };
  EXPECT_EQ(hidden(false), 0);
  EXPECT_GT(hidden(true), 0);
}

TEST(Load, GivesEveryViewerTheLinkThatIsAskedFor) {
  const sim::LinkPair wifi = sim::linkNamed("wifi").value().links();
  LoadOptions options = smallLoad(20);
  options.mix = Mix::kMixed;
  options.links = wifi;
  std::vector<size_t> roles(20);
  std::iota(roles.begin(), roles.end(), 0);
  size_t slow = 0;
  for (const LoadViewer& v : viewersOf(LoadTours(smallWorld()->hierarchy.scene()), options, roles)) {
    EXPECT_EQ(v.cast.links.up.latency, wifi.up.latency);
    EXPECT_EQ(v.cast.links.down.loss, wifi.down.loss);
    slow += v.cast.links.down.bytes_per_second < wifi.down.bytes_per_second;
  }
  EXPECT_EQ(slow, 1u);
}

// Of tours all but the paths is alike: no link, screen or tolerance of its own, no jumps.
TEST(Load, FliesToursThatDifferInNothingElse) {
  LoadOptions options = smallLoad(20);
  options.mix = Mix::kTours;
  std::vector<size_t> roles(20);
  std::iota(roles.begin(), roles.end(), 0);
  const LoadTours tours(smallWorld()->hierarchy.scene());
  std::map<const proto::Path*, size_t> flying;
  for (const LoadViewer& v : viewersOf(tours, options, roles)) {
    ++flying[v.cast.flight.path.get()];
    EXPECT_EQ(v.cast.flight.jump_every, Duration{});
    EXPECT_EQ(v.cast.request.tau_px, options.tau_px);
    EXPECT_EQ(v.cast.request.lens.width_px, proto::ViewRequest{}.lens.width_px);
    EXPECT_EQ(v.cast.links.down.bytes_per_second, options.links.down.bytes_per_second);
  }
  EXPECT_EQ(flying,
            (std::map<const proto::Path*, size_t>{
                {tours.survey.get(), 8}, {tours.canyon.get(), 7}, {tours.spin.get(), 2}, {tours.orbit.get(), 3}}));
}

CellTables rowWith(const char* policy, uint64_t viewers, double missed_share) {
  return {.row = {{"policy", policy},
                  {"phases", "random"},
                  {"start", "early"},
                  {"slack_ms", 0},
                  {"queues", "shared"},
                  {"viewers", viewers},
                  {"keyframes", uint64_t{10'000}},
                  {"missed_share", missed_share}}};
}

// The number up to which all are served: that a larger one happened to be served says little.
TEST(Load, FindsTheCapacityAmongTheNumbersThatWereTried) {
  const auto rows = capacitiesOf({rowWith("edf", 40, 0.0005), rowWith("edf", 20, 0), rowWith("edf", 80, 0.5),
                                  rowWith("edf", 160, 0), rowWith("fair", 20, 0.001), rowWith("fair", 40, 0.1),
                                  rowWith("fifo", 20, 0), rowWith("fifo", 40, 0), rowWith("least-laxity", 20, 0)});
  ASSERT_EQ(rows.size(), 3u);
  const auto is = [&](size_t row, const char* policy, uint64_t most, uint64_t fewest_missing) {
    EXPECT_EQ(rows[row]["policy"], policy);
    EXPECT_EQ(rows[row]["most_viewers"], most);
    EXPECT_EQ(rows[row]["fewest_missing"], fewest_missing);
  };
  is(0, "edf", 40, 80);
  is(1, "fair", 0, 20);
  is(2, "fifo", 40, 0);
  const std::vector first(rows.begin(), rows.begin() + 1);
  EXPECT_EQ(capacityCsv(first),
            "policy,phases,start,slack_ms,queues,most_viewers,fewest_missing\nedf,random,early,0,shared,40,80\n");
}

// A worker of its own has a queue of its own, of one kind or the other.
TEST(Load, OneWorkerHasNobodyToStealFrom) {
  LoadOptions options = smallLoad(52);
  options.start = LoadStart::kEarly;
  const LoadRun shared = runLoad(smallWorld(), options);
  options.queues = LoadQueues::kStealing;
  const LoadRun stealing = runLoad(smallWorld(), options);
  EXPECT_GT(shared.figures.missed, 0u);
  EXPECT_EQ(shared.lateness_ms, stealing.lateness_ms);
  EXPECT_EQ(shared.used, stealing.used);
}

// Idle workers help, so stealing serves as much.
TEST(Load, StealingUsesAllWorkers) {
  for (const uint64_t seed : {1, 2, 3}) {
    LoadOptions options = smallLoad(170);
    options.workers = 4;
    options.seed = seed;
    options.start = LoadStart::kEarly;
    const LoadFigures shared = run(options);
    options.queues = LoadQueues::kStealing;
    const LoadFigures stealing = run(options);
    EXPECT_NEAR(stealing.utilisation, shared.utilisation, 0.02);
    EXPECT_GT(stealing.keyframes, shared.keyframes * 95 / 100);
  }
}

TEST(Load, FindsTheMostViewersThatAreServed) {
  LoadOptions options = smallLoad(8);
  options.phases = Phases::kStaggered;
  options.start = LoadStart::kEarly;
  const size_t most = maxViewers(smallWorld(), options).value();
  EXPECT_GE(most, 30u);
  EXPECT_LE(most, 51u);
}

TEST(Load, GivesTheSameFilesForAnyNumberOfThreads) {
  LoadRequest request;
  request.base = smallLoad(10);
  request.base.mix = Mix::kMixed;
  request.policies = {"edf", "fair"};
  const auto runs = runsOf(request);
  ASSERT_TRUE(runs.ok());
  ASSERT_EQ(runs->size(), 2u * 3u * 2u);
  const auto filesOf = [&](unsigned threads) {
    const test::TemporaryFolder folder;
    const auto tables = runAll(smallWorld(), *runs, {}, {}, threads, [](size_t) {});
    EXPECT_TRUE(writeCells(folder / "out", {{"seed", 1}}, kLoadNames, tables.value()).ok());
    std::vector<std::vector<char>> files;
    for (const char* name : {"results.csv", "results.json", "utilisation.csv", "lateness.csv"})
      files.push_back(test::slurp(folder / ("out/" + std::string(name))));
    return files;
  };
  const auto one = filesOf(1);
  for (const auto& file : one) EXPECT_GT(file.size(), 500u);
  EXPECT_EQ(one, filesOf(2));
}

TEST(Load, RefusesWhatIsUnknownByName) {
  const auto refusal = [](LoadRequest request) {
    const auto runs = runsOf(request);
    return runs.ok() ? std::string() : runs.error().message;
  };
  EXPECT_EQ(refusal({.base = {}, .policies = {"luck"}}),
            "there is no policy 'luck'; choose one of fifo, edf, least-laxity, fair");
  EXPECT_NE(refusal({.base = {}, .phases = {"moon"}}).find("'moon'"), std::string::npos);
  EXPECT_NE(refusal({.base = {}, .starts = {"never"}}).find("'never'"), std::string::npos);
  EXPECT_EQ(refusal({.base = {}, .queues = {"stack"}}),
            "there is no kind of queues 'stack'; choose one of shared, stealing");
  EXPECT_NE(mixNamed("cocktail").error().message.find("'cocktail'"), std::string::npos);
}

}  // namespace
}  // namespace foreland::lab
