// The grid of `foreland bench latency`, and its flights over a small scene.
#include <gtest/gtest.h>

#include <set>
#include <sstream>

#include "lab/latency/experiment.h"
#include "oracle/scene_truth.h"
#include "server/view/tour.h"
#include "tests/support/scene.h"

namespace foreland::lab {
namespace {

using proto::Predictor;
using proto::Strategy;

TEST(LatencyGrid, HasAllRoundTripsForAllStrategiesAndPredictors) {
  const auto cells = cellsOf({});
  ASSERT_TRUE(cells.ok());
  std::set<std::pair<std::string, double>> seen;
  for (const LatencyCell& cell : *cells)
    if (cell.keyframes == proto::KeyframeInterval{} && cell.tau_px == 1) seen.insert({cell.how(), cell.round_trip_ms});
  EXPECT_EQ(seen.size(), 8u * 5u);
  const auto full = cellsOf({.size = GridSize::kFull});
  EXPECT_EQ(full->size(), 8u * 5u * 4u * 3u);
  EXPECT_GT(std::count_if(cells->begin(), cells->end(), [](const auto& c) { return c.keyframes.isAdaptive(); }), 0);
  for (const LatencyCell& cell : *cells) EXPECT_EQ(std::count(cells->begin(), cells->end(), cell), 1) << cell.how();
}

TEST(LatencyGrid, TakesWhatIsAskedForInAllCombinations) {
  const auto cells = cellsOf({.strategies = {"predict", "delay"},
                              .predictors = {"kalman"},
                              .links = {"lte", "fixed"},
                              .round_trips_ms = {10, 20},
                              .keyframes_ms = {"150"}});
  ASSERT_TRUE(cells.ok());
  EXPECT_EQ(cells->size(), 2u * (1u + 2u));
}

TEST(LatencyGrid, RefusesWhatIsUnknownOrOutOfRangeByName) {
  const auto refusal = [](const GridRequest& request) {
    const auto cells = cellsOf(request);
    return cells.ok() ? std::string() : cells.error().message;
  };
  EXPECT_EQ(refusal({.strategies = {"guess"}}), "there is no strategy 'guess'; choose delay, current or predict");
  EXPECT_NE(refusal({.predictors = {"oracle"}}).find("'oracle'"), std::string::npos);
  EXPECT_NE(refusal({.links = {"pigeon"}}).find("'pigeon'"), std::string::npos);
  EXPECT_EQ(refusal({.keyframes_ms = {"0"}}),
            "a keyframe interval is 20 to 10000 ms, two of them with a dash between (100-500), or adaptive; not 0");
  EXPECT_EQ(refusal({.round_trips_ms = {-1}}), "a round trip in ms must be 0 to 2000, not -1");
  EXPECT_EQ(refusal({.round_trips_ms = {NAN}}), "a round trip in ms must be 0 to 2000, not nan");
  EXPECT_EQ(refusal({.taus_px = {0}}), "a tolerance in pixels must be 0.01 to 1000, not 0");
}

LatencyFlight smallFlight(const char* tour, double seconds) {
  static const auto scene = test::makeScene(301, 217, 11);
  LatencyFlight flight{.world = std::make_shared<server::World>(scene),
                       .path = server::planTour(*scene, tour, seconds + 4).value(),
                       .seconds = seconds,
                       .lens = {1.0471975511965976, 320, 180}};
  flight.path.start = Time{} + kStanding;
  return flight;
}

CellFlight fly(const LatencyFlight& flight, const LatencyCell& cell) {
  oracle::Oracle oracle(
      oracle::truthOf(std::shared_ptr<const terrain::Scene>(flight.world, &flight.world->hierarchy.scene())));
  return flyCell(flight, cell, oracle);
}

std::set<std::string> linesOf(const std::string& csv) {
  std::istringstream in(csv);
  std::set<std::string> lines;
  for (std::string line; std::getline(in, line);) lines.insert(line);
  return lines;
}

// Judging only watches: what is not about judged frames is the same, and those of the lower rate are judged alike.
TEST(LatencyFlight, IsTheSameHoweverManyFramesAreJudged) {
  LatencyFlight flight = smallFlight("canyon", 3);
  for (const Strategy strategy : {Strategy::kDelay, Strategy::kCurrent, Strategy::kPredict}) {
    const LatencyCell cell{strategy, Predictor::kKalman, "wifi", 0, proto::kAdaptiveInterval, 1};
    flight.judged = {};
    const CellTables all = tablesOf(fly(flight, cell), flight.seconds);
    flight.judged = JudgedFrames(5);
    const CellTables few = tablesOf(fly(flight, cell), flight.seconds);
    EXPECT_EQ(all.row["frames_judged"], 30);
    EXPECT_EQ(few.row["frames_judged"], 6);
    for (const char* figure : {"frames", "frames_outside", "triangles", "delay_mean_ms", "delay_max_ms", "keyframes",
                               "late_keyframes", "compute_mean_ms", "bytes_down", "bytes_up", "down_kbit_s"})
      EXPECT_EQ(few.row[figure], all.row[figure]) << figure << " " << cell.how();
    EXPECT_EQ(few.rows[1], all.rows[1]);  // keyframes.csv
    const std::set<std::string> few_lines = linesOf(few.rows[0].second), all_lines = linesOf(all.rows[0].second);
    EXPECT_EQ(few_lines.size(), 1u + 6u);
    EXPECT_TRUE(std::includes(all_lines.begin(), all_lines.end(), few_lines.begin(), few_lines.end())) << cell.how();
  }
}

// The paper's bound, and what each strategy is about.
TEST(LatencyFlight, BoundsTheTotalByTheTermsOfEachStrategy) {
  const LatencyFlight flight = smallFlight("canyon", 3);
  for (const double round_trip_ms : {0.0, 300.0})
    for (const auto& [strategy, predictor] :
         {std::pair{Strategy::kDelay, Predictor::kHold}, std::pair{Strategy::kCurrent, Predictor::kHold},
          std::pair{Strategy::kPredict, Predictor::kHold}, std::pair{Strategy::kPredict, Predictor::kKalman},
          std::pair{Strategy::kPredict, Predictor::kKnownPath}}) {
      const CellFlight flown =
          fly(flight, {strategy, predictor, "fixed", round_trip_ms, {Duration::milliseconds(200)}, 1});
      const CellFigures figures = figuresOf(flown, flight.seconds);
      const std::string what = flown.cell.how();
      EXPECT_EQ(figures.judged, 30u) << what;
      EXPECT_EQ(figures.bound_violations, 0u) << what;
      EXPECT_LE(figures.terms[static_cast<size_t>(Term::kRefinement)].max_px, 1.01) << what;
      EXPECT_GT(figures.terms[0].max_px, 0.1) << what;
      const bool is_predicted = strategy == Strategy::kPredict;
      EXPECT_EQ(figures.delay_mean_ms > 150, !is_predicted) << what;
      EXPECT_EQ(figures.terms[static_cast<size_t>(Term::kView)].max_px > 0, strategy == Strategy::kCurrent) << what;
      EXPECT_EQ(figures.terms[static_cast<size_t>(Term::kExtrapolation)].max_px > 1e-3,
                is_predicted && predictor != Predictor::kKnownPath)
          << what;
      EXPECT_GT(figures.bytes_down, 100u);
    }
}

TEST(LatencyFlight, KeepsTheToleranceOnAKnownPathWhateverTheRoundTrip) {
  const LatencyFlight flight = smallFlight("survey", 2);
  for (const double round_trip_ms : {0.0, 400.0}) {
    const CellFlight flown = fly(
        flight, {Strategy::kPredict, Predictor::kKnownPath, "fixed", round_trip_ms, {Duration::milliseconds(200)}, 1});
    const CellFigures figures = figuresOf(flown, flight.seconds);
    EXPECT_EQ(figures.over_tau, 0u) << round_trip_ms;
    EXPECT_EQ(figures.late, 0u) << round_trip_ms;
  }
}

TEST(LatencyExperiment, LeavesTheSameFilesForAnyNumberOfThreads) {
  const LatencyFlight flight = smallFlight("orbit", 1);
  const auto cells =
      cellsOf({.predictors = {"velocity", "kalman"}, .links = {"fixed", "starlink"}, .round_trips_ms = {100}});
  const auto filesOf = [&](unsigned threads) {
    const test::TemporaryFolder folder;
    const auto tables = flyGrid(flight, *cells, {}, {}, threads, [](size_t) {});
    EXPECT_TRUE(writeCells(folder / "out", {{"seed", 1}}, kLatencyNames, tables.value()).ok());
    std::vector<std::string> files;
    for (const char* name : {"results.csv", "frames.csv", "keyframes.csv", "results.json"}) {
      const std::vector<char> bytes = test::slurp(folder / ("out/" + std::string(name)));
      files.emplace_back(bytes.begin(), bytes.end());
    }
    return files;
  };
  const std::vector<std::string> one = filesOf(1);
  for (const std::string& text : one) EXPECT_GT(text.size(), 500u);
  EXPECT_EQ(one, filesOf(3));
}

TEST(Bound, IsCheckedOfAllFlights) {
  const auto row = [](uint64_t violations) { return CellTables{.row = {{"bound_violations", violations}}}; };
  EXPECT_TRUE(checkBound({}).ok());
  EXPECT_TRUE(checkBound({row(0), row(0)}).ok());
  const Status refused = checkBound({row(0), row(3), row(0)});
  ASSERT_FALSE(refused.ok());
  EXPECT_NE(refused.error().message.find("flight 1: in 3 frames"), std::string::npos) << refused.error().message;
}

}  // namespace
}  // namespace foreland::lab
