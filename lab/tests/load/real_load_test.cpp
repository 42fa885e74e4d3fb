// A load in real time: what is asked of it, what is read from its server, and one short run on loopback. Times are not
// judged: the machine may be busy. That bytes arrive when the link says so is tested in lab/tests/proxy.
#include "lab/load/real_load.h"

#include <gtest/gtest.h>

#include <map>
#include <nlohmann/json.hpp>

#include "lab/load/server_counts.h"
#include "tests/apps/expect_refusal.h"
#include "tests/support/program.h"
#include "tests/support/scene.h"

namespace foreland::lab {
namespace {

LoadOptions realOptions() {
  LoadOptions options;
  options.policy = LoadPolicy::kFair;
  options.start = LoadStart::kEarly;
  return options;
}

TEST(RealLoad, RunsAsServersDoAndAsNothingElse) {
  EXPECT_TRUE(checkReal(realOptions()).ok());
  LoadOptions edf = realOptions(), late = realOptions(), many = realOptions();
  edf.policy = LoadPolicy::kEdf;
  late.start = LoadStart::kLate;
  many.cluster.servers = 2;
  EXPECT_NE(checkReal(edf).error().message.find("the policy is fair"), std::string::npos);
  EXPECT_NE(checkReal(late).error().message.find("starts are early"), std::string::npos);
  EXPECT_NE(checkReal(many).error().message.find("one server"), std::string::npos);
  many.cluster.events = {{ServerEvent::What::kDrain, 0, 1}};
  EXPECT_TRUE(checkReal(many).ok());
}

TEST(RealLoad, ReadsWhatTheServerCounts) {
  const std::string page =
      "# TYPE foreland_keyframes_total counter\nforeland_keyframes_total 50\nforeland_late_keyframes_total 3\n"
      "process_cpu_seconds_total 1.5\n";
  const auto counts = parseCounts(page);
  ASSERT_TRUE(counts.ok()) << counts.error().message;
  EXPECT_EQ(counts->keyframes, 50);
  EXPECT_EQ(counts->late_keyframes, 3);
  EXPECT_EQ(counts->cpu_s, 1.5);
  EXPECT_NE(parseCounts("nothing").error().message.find("foreland_keyframes_total"), std::string::npos);
}

TEST(RealLoad, ComparesTheSameKeyframesOfBothWorlds) {
  ViewerTally tally;
  LightViewer::Received keyframe;
  keyframe.is_keyframe = true;
  for (const int64_t at_us : {-1, 0, 10, 20}) {  // of these two are for times of the window
    keyframe.time = Time{at_us};
    keyframe.lateness = Duration{at_us * 1000 - 5000};
    tally.add(keyframe, 100, Time{0}, Time{20});
  }
  EXPECT_EQ(tally.keyframes, 2u);
  EXPECT_EQ(tally.late, 1u);
  EXPECT_EQ(tally.bytes, 200u);
  LoadRun virtual_time;
  virtual_time.viewers = {tally, tally};
  virtual_time.figures.missed = 3, virtual_time.figures.at_once = 2;
  RealLoad real;
  real.viewers = {tally, {}};
  real.server_missed = 7;
  std::map<std::string, Agreement> by_name;
  for (const Agreement& a : agreementOf(virtual_time, real)) by_name.emplace(a.name, a);
  EXPECT_EQ(by_name.at("keyframes").difference(), -2);
  EXPECT_EQ(by_name.at("late").real_time, 1);
  EXPECT_EQ(by_name.at("lateness_max_ms").real_time, 5);
  EXPECT_EQ(by_name.at("bytes_per_viewer").virtual_time, 200);
  EXPECT_EQ(by_name.at("bytes_per_viewer").real_time, 100);
  EXPECT_EQ(by_name.at("server_missed").difference(), 2);  // those after jumps count in both
  EXPECT_EQ(largestByteDifference(virtual_time, real), 1);
}

// Whatever the machine does, the server serves the viewers that fly over its links.
TEST(RealLoad, FliesOverLoopbackAndReportsBothWorlds) {
  const test::TemporaryFolder folder;
  const std::string scene = folder / "land.fls", out = folder / "out";
  test::FormulaSource source(129, 129, test::hills(8));
  ASSERT_TRUE(terrain::buildScene(source, {scene, 0.1, 1}).ok());
  const test::ProgramResult run =
      test::runProgram("bench",
                       {"load", scene, "--viewers", "3", "--mix", "survey", "--tau", "20", "--predictor", "path",
                        "--seconds", "2", "--real", "--out", out, "--json"},
                       {.streams = test::Streams::kOutputOnly});
  ASSERT_EQ(run.exit_code, 0) << run.output;
  const auto report = nlohmann::json::parse(run.output, nullptr, false);
  ASSERT_FALSE(report.is_discarded()) << run.output;
  EXPECT_EQ(report["policy"], "fair");
  for (const char* key : {"keyframes", "bytes_per_viewer", "server_keyframes"}) {
    bool is_there = false;
    for (const auto& row : report["agreement"])
      if (row["figure"] == key) is_there = row["virtual"] > 0 && row["real"] > 0;
    EXPECT_TRUE(is_there) << key << run.output;
  }
  EXPECT_TRUE(std::filesystem::exists(folder / "out/agreement.json"));
}

// Half of the viewers lose their server or are told to leave it, and go on with what they hold.
TEST(RealLoad, MovesViewersToAnotherServerAndReportsWhatThatCosts) {
  const test::TemporaryFolder folder;
  const std::string scene = folder / "land.fls";
  test::FormulaSource source(129, 129, test::hills(8));
  ASSERT_TRUE(terrain::buildScene(source, {scene, 0.1, 1}).ok());
  for (const auto& [event, cause] : {std::pair("--drain", "handed_over"), std::pair("--fail", "lost")}) {
    const test::ProgramResult run =
        test::runProgram("bench",
                         {"load", scene, "--viewers", "4", "--mix", "survey", "--tau", "20", "--seconds", "3", "--real",
                          "--servers", "2", event, "1@0.5", "--json"},
                         {.streams = test::Streams::kOutputOnly});
    ASSERT_EQ(run.exit_code, 0) << run.output;
    std::map<std::string, std::pair<double, double>> figures;
    const auto report = nlohmann::json::parse(run.output, nullptr, false);
    ASSERT_FALSE(report.is_discarded()) << run.output;
    for (const auto& row : report["agreement"])
      figures[row["figure"].get<std::string>()] = {row["virtual"].get<double>(), row["real"].get<double>()};
    const auto [virtual_moves, real_moves] = figures.at(cause);
    EXPECT_EQ(virtual_moves, 2);
    EXPECT_GE(real_moves, 1) << run.output;
    EXPECT_LE(real_moves, 2);
    EXPECT_EQ(figures.at("afresh").second, 0);
    for (const char* bytes : {"move_up_mean_bytes", "move_down_mean_bytes"}) {
      EXPECT_GT(figures.at(bytes).first, 0) << bytes;
      EXPECT_GT(figures.at(bytes).second, 0) << bytes;
    }
  }
}

TEST(RealLoad, RefusesWhatServersDoNotByName) {
  using test::expectRefusal;
  expectRefusal("bench", {"load", "none.fls", "--real", "--policies", "edf"}, {"--real", "the policy is fair"});
  expectRefusal("bench", {"load", "none.fls", "--real", "--phases", "random,staggered"}, {"--real", "2", "--phases"});
  expectRefusal("bench", {"load", "none.fls", "--real", "--most-viewers"}, {"--real", "--most-viewers"});
  expectRefusal("bench", {"load", "none.fls", "--real", "--servers", "2"}, {"--real"});
  for (const char* event : {"--join", "--drain"})
    expectRefusal("bench",
                  {"load", "none.fls", "--real", "--servers", event == std::string("--join") ? "2" : "3", event, "1@1"},
                  {"--real", "one is drained or fails"});
  expectRefusal("bench", {"load", "none.fls", "--real", "--servers", "2", "--drain", "1@1", "--balance", "migrate"},
                {"--real", "round-robin"});
  expectRefusal("bench", {"load", "none.fls", "--predictor", "luck"}, {"--predictor", "'luck'", "velocity"});
  expectRefusal("bench", {"load", "none.fls", "--predictor", "path", "--servers", "2"}, {"--predictor path"});
}

}  // namespace
}  // namespace foreland::lab
