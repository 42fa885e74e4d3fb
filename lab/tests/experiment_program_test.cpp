// The experiments of `foreland bench` as a user calls them: refusals by name, and files that do not depend on the run.
#include <gtest/gtest.h>

#include <fstream>

#include "tests/apps/expect_refusal.h"
#include "tests/support/scene.h"

namespace foreland::test {
namespace {

class ExperimentProgram : public testing::Test {
 protected:
  void SetUp() override {
    FormulaSource source(129, 129, [](uint32_t x, uint32_t y) { return 40 * std::sin(0.1 * x) * std::cos(0.13 * y); });
    ASSERT_TRUE(terrain::buildScene(source, {folder_ / "scene.fls", 0.1, 1}).ok());
  }
  std::string scene() const { return folder_ / "scene.fls"; }
  void refuses(const std::vector<std::string>& more, const std::vector<std::string>& words) const {
    std::vector<std::string> arguments{"latency", scene(), "--seconds", "1", "--width", "160", "--height", "90"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    expectRefusal("bench", arguments, words);
  }
  TemporaryFolder folder_;
};

TEST_F(ExperimentProgram, RefusesWhatMakesNoSenseByName) {
  refuses({"--strategies", "guess"}, {"'guess'", "predict"});
  refuses({"--predictors", "oracle"}, {"'oracle'", "kalman"});
  refuses({"--links", "pigeon"}, {"'pigeon'", "starlink"});
  refuses({"--keyframes-ms", "0"}, {"keyframe interval", "not 0"});
  refuses({"--round-trips", "-5"}, {"round trip", "-5"});
  refuses({"--taus", "0"}, {"tolerance", "not 0"});
  refuses({"--judge-hz", "3"}, {"judged", "not 3"});
  refuses({"--tour", "moon"}, {"moon"});
  refuses({"--calibration", folder_ / "none.json"}, {"none.json"});
  refuses({"--track", folder_ / "none.igc"}, {"none.igc"});
}

TEST_F(ExperimentProgram, RefusesBrokenTraces) {
  std::ofstream(folder_ / "good.trace") << "1\n2\n";
  std::ofstream(folder_ / "bad.trace") << "1\nsoon\n";
  refuses({"--links", "trace"}, {"--trace-up", "--trace-down"});
  refuses({"--links", "trace", "--trace-up", folder_ / "good.trace", "--trace-down", folder_ / "bad.trace"},
          {"bad.trace:2", "'soon'"});
  refuses({"--trace-up", folder_ / "good.trace", "--trace-down", folder_ / "good.trace"}, {"--links trace"});
}

TEST_F(ExperimentProgram, WritesTheSameFilesInEveryRun) {
  const auto files = [&](const std::string& out, const std::string& threads, const std::string& judge_hz) {
    const ProgramResult result = runProgram(
        "bench", {"latency",       scene(),  "--seconds",    "1",          "--width",        "160",
                  "--height",      "90",     "--strategies", "predict",    "--predictors",   "velocity",
                  "--round-trips", "50,100", "--links",      "fixed,wifi", "--out",          folder_ / out,
                  "--threads",     threads,  "--judge-hz",   judge_hz,     "--keyframes-ms", "100,adaptive"});
    EXPECT_EQ(result.exit_code, 0) << result.output;
    std::vector<std::vector<char>> all;
    for (const char* name : {"results.csv", "results.json", "frames.csv", "keyframes.csv"})
      all.push_back(slurp(folder_ / (out + "/" + name)));
    return all;
  };
  const auto first = files("a", "1", "10"), fewer = files("c", "2", "2");
  for (const auto& file : first) EXPECT_GT(file.size(), 200u);
  EXPECT_EQ(first, files("b", "2", "10"));
  EXPECT_EQ(fewer, files("d", "1", "2"));
  EXPECT_LT(fewer[2].size(), first[2].size());
  EXPECT_EQ(fewer[3], first[3]);
}

// An experiment in a file.
class ExperimentFile : public ExperimentProgram {
 protected:
  std::string file(const std::string& text) const {
    std::ofstream(folder_ / "e.toml") << text;
    return folder_ / "e.toml";
  }
  void refusesFile(const std::string& text, const std::vector<std::string>& words) const {
    expectRefusal("bench", {"run", file(text), "--out", folder_ / "out"}, words);
    EXPECT_FALSE(std::filesystem::exists(folder_ / "out"));
  }
  // Both experiments in small, two seeds.
  std::string latencyText() const {
    return "experiment = 'latency'\nseeds = [1, 2]\nmetrics = ['total_p99_px', 'down_kbit_s']\n[all]\nscene = '" +
           scene() +
           "'\nseconds = 1\nwidth = 160\nheight = 90\nstrategies = 'predict'\npredictors = ['velocity']\n"
           "[[run]]\nname = 'survey'\nround-trips = [50, 100]\n[[run]]\nname = 'wifi'\ntour = 'orbit'\nlinks = "
           "['wifi']\n";
  }
  std::vector<std::vector<char>> runFiles(const std::string& text, const std::string& out, const std::string& threads) {
    const ProgramResult result = runProgram("bench", {"run", file(text), "--out", folder_ / out, "--threads", threads});
    EXPECT_EQ(result.exit_code, 0) << result.output;
    std::vector<std::vector<char>> all{slurp(folder_ / (out + "/results.csv"))};
    for (const char* part : {"survey-seed1", "survey-seed2", "wifi-seed1", "wifi-seed2"})
      for (const char* name : {"results.csv", "results.json", "frames.csv", "keyframes.csv"})
        all.push_back(slurp(folder_ / (out + "/" + part + "/" + name)));
    return all;
  }
};

TEST_F(ExperimentFile, WritesTheSameFilesInEveryRunAndAfterAStop) {
  const auto first = runFiles(latencyText(), "a", "1");
  const std::string all(first[0].begin(), first[0].end());
  EXPECT_EQ(
      all.substr(0, all.find('\n')),
      "run,seed,strategy,predictor,link,round_trip_ms,keyframe_ms,longest_keyframe_ms,tau_px,total_p99_px,down_kbit_s");
  EXPECT_EQ(std::count(all.begin(), all.end(), '\n'), 1 + 2 * 3);
  EXPECT_EQ(first, runFiles(latencyText(), "b", "2"));

  // Stopped between cells, in a cell, and while the tables were written.
  std::vector<std::filesystem::path> cells;
  for (const auto& entry : std::filesystem::directory_iterator(folder_ / "a/cells")) cells.push_back(entry.path());
  ASSERT_EQ(cells.size(), 6u);
  std::filesystem::remove(cells[0]);
  std::filesystem::rename(cells[1], cells[1].string() + ".part");
  std::filesystem::remove(folder_ / "a/results.csv");
  std::filesystem::remove_all(folder_ / "a/wifi-seed2");
  EXPECT_EQ(first, runFiles(latencyText(), "a", "2"));
}

// What was judged at one rate is not taken for another.
TEST_F(ExperimentFile, JudgesAgainAtAnotherRate) {
  const auto atRate = [&](const std::string& hz) {
    std::string text = latencyText();
    return text.insert(text.find("[[run]]"), "judge-hz = " + hz + "\n");
  };
  const auto few = runFiles(atRate("2.5"), "a", "2");
  EXPECT_NE(few, runFiles(atRate("10"), "a", "1"));
  EXPECT_EQ(few, runFiles(atRate("2.5"), "b", "1"));
  EXPECT_EQ(few, runFiles(atRate("2.5"), "a", "1"));
}

TEST_F(ExperimentFile, GivesTheRowsOfTheCommand) {
  const std::string text = "experiment = 'load'\n[[run]]\nname = 'few'\nscene = '" + scene() +
                           "'\nviewers = 4\nseconds = 1\npolicies = ['edf']\nphases = 'random'\n";
  const ProgramResult run = runProgram("bench", {"run", file(text), "--out", folder_ / "run"});
  EXPECT_EQ(run.exit_code, 0) << run.output;
  const ProgramResult command = runProgram("bench", {"load", scene(), "--viewers", "4", "--seconds", "1", "--policies",
                                                     "edf", "--phases", "random", "--out", folder_ / "few"});
  EXPECT_EQ(command.exit_code, 0) << command.output;
  for (const char* name : {"results.csv", "utilisation.csv", "lateness.csv"})
    EXPECT_EQ(slurp(folder_ / ("run/few/" + std::string(name))), slurp(folder_ / ("few/" + std::string(name))));
}

TEST_F(ExperimentFile, ComparesWithTilesAsTheCommandDoesAndAfterAStop) {
  const std::string text = "experiment = 'tiles'\n[[run]]\nname = 'few'\nscene = '" + scene() +
                           "'\nseconds = 2\nwidth = 160\nheight = 90\nlink = 'lte'\n";
  const auto files = [&](const std::string& of) {
    std::vector<std::vector<char>> all;
    for (const char* name : {"results.csv", "over_time.csv"}) all.push_back(slurp(folder_ / (of + "/" + name)));
    return all;
  };
  const auto run = [&] {
    const ProgramResult result = runProgram("bench", {"run", file(text), "--out", folder_ / "run"});
    EXPECT_EQ(result.exit_code, 0) << result.output;
    return files("run/few");
  };
  const auto first = run();
  EXPECT_EQ(std::count(first[0].begin(), first[0].end(), '\n'), 5);
  EXPECT_GT(first[1].size(), 500u);
  const ProgramResult command = runProgram("bench", {"tiles", scene(), "--seconds", "2", "--width", "160", "--height",
                                                     "90", "--link", "lte", "--out", folder_ / "few"});
  EXPECT_EQ(command.exit_code, 0) << command.output;
  EXPECT_EQ(first, files("few"));
  const auto all = slurp(folder_ / "run/results.csv");

  // Our own flight, the search and three of tiles; one was stopped.
  std::vector<std::filesystem::path> cells;
  for (const auto& entry : std::filesystem::directory_iterator(folder_ / "run/cells")) cells.push_back(entry.path());
  ASSERT_EQ(cells.size(), 5u);
  std::filesystem::remove(cells[2]);
  std::filesystem::remove_all(folder_ / "run/few");
  EXPECT_EQ(first, run());
  EXPECT_EQ(all, slurp(folder_ / "run/results.csv"));
}

TEST_F(ExperimentFile, IsRefusedByNameBeforeAnythingRuns) {
  const std::string load = "experiment = 'load'\n", run = "[[run]]\nname = 'a'\nscene = '" + scene() + "'\n";
  refusesFile("experiment = 'luck'\n" + run, {"experiment", "latency", "load"});
  refusesFile(load + "sedes = [1]\n" + run, {"e.toml:2", "'sedes'"});
  refusesFile(load + "seeds = ['one']\n" + run, {"e.toml:2", "'seeds'"});
  refusesFile(load + "seeds = []\n" + run, {"'seeds'"});
  refusesFile(load + "metrics = ['luck']\n" + run, {"'luck'"});
  refusesFile(load, {"[[run]]"});
  refusesFile(load + run + "viewers =\n", {"e.toml:5"});
  refusesFile(load + run + run, {"two runs", "'a'"});
  refusesFile(load + "[[run]]\nname = '../a'\n", {"needs a name"});
  refusesFile(load + "[[run]]\nname = 'a'\n", {"e.toml:2", "run 'a'", "scene"});
  refusesFile(load + run + "viewers = 0\n", {"run 'a'", "viewers"});
  refusesFile(load + run + "vieewers = 10\n", {"run 'a'", "vieewers"});
  refusesFile(load + run + "policies = ['edf', 'luck']\n", {"run 'a'", "'luck'"});
  refusesFile(load + run + "out = 'b'\n", {"e.toml:5", "'out'"});
  refusesFile(load + run + "viewers = {}\n", {"e.toml:5", "'viewers'"});
  refusesFile("experiment = 'latency'\n" + run + "keyframes-ms = 0\n", {"run 'a'", "keyframe interval", "not 0"});
  refusesFile("experiment = 'latency'\n" + run + "judge-hz = 3\n", {"run 'a'", "judged", "not 3"});
  refusesFile("experiment = 'tiles'\n" + run + "link = 'pigeon'\n", {"run 'a'", "'pigeon'", "starlink"});
  refusesFile("experiment = 'tiles'\n" + run + "viewers = 2\n", {"run 'a'", "viewers"});
  expectRefusal("bench", {"run", file(load + run)}, {"--out"});
  expectRefusal("bench", {"run", folder_ / "none.toml", "--out", folder_ / "out"}, {"none.toml"});
}

TEST_F(ExperimentProgram, ComparesWithTilesAlikeInEveryRun) {
  const auto table = [&](const std::string& out) {
    const ProgramResult result = runProgram("bench", {"tiles", scene(), "--seconds", "2", "--width", "160", "--height",
                                                      "90", "--jump", "--out", folder_ / out});
    EXPECT_EQ(result.exit_code, 0) << result.output;
    EXPECT_GT(slurp(folder_ / (out + "/over_time.csv")).size(), 500u);
    return slurp(folder_ / (out + "/results.csv"));
  };
  const auto first = table("a");
  EXPECT_EQ(std::count(first.begin(), first.end(), '\n'), 5);
  EXPECT_EQ(first, table("b"));
  expectRefusal("bench", {"tiles", scene(), "--link", "pigeon"}, {"'pigeon'", "starlink"});
  expectRefusal("bench", {"tiles", scene(), "--tau", "0"}, {"--tau"});
}

// Several numbers of viewers, what they come to, and a link and occlusion that are not the usual ones.
TEST_F(ExperimentProgram, LoadsWithSeveralNumbersOfViewersAlikeInEveryRun) {
  const auto files = [&](const std::string& out, const std::string& threads) {
    const ProgramResult result =
        runProgram("bench", {"load",        scene(),    "--viewers", "3,6,9",       "--seconds", "1",      "--policies",
                             "edf,fair",    "--phases", "random",    "--starts",    "early",     "--link", "wifi",
                             "--occlusion", "on",       "--out",     folder_ / out, "--threads", threads});
    EXPECT_EQ(result.exit_code, 0) << result.output;
    std::vector<std::vector<char>> all;
    for (const char* name : {"capacity.csv", "results.csv", "results.json", "utilisation.csv", "lateness.csv"})
      all.push_back(slurp(folder_ / (out + "/" + name)));
    return all;
  };
  const auto first = files("a", "1");
  EXPECT_EQ(std::count(first[0].begin(), first[0].end(), '\n'), 1 + 2);
  EXPECT_EQ(std::count(first[1].begin(), first[1].end(), '\n'), 1 + 2 * 3);
  EXPECT_EQ(first, files("b", "2"));
}

TEST_F(ExperimentProgram, RefusesLoadsThatMakeNoSenseByName) {
  const auto refuses = [&](const std::vector<std::string>& more, const std::vector<std::string>& words) {
    std::vector<std::string> arguments{"load", scene()};
    arguments.insert(arguments.end(), more.begin(), more.end());
    expectRefusal("bench", arguments, words);
  };
  refuses({"--link", "pigeon"}, {"'pigeon'", "starlink"});
  refuses({"--link", "trace"}, {"--trace-up", "--trace-down"});
  refuses({"--trace-up", "none", "--trace-down", "none"}, {"--link trace"});
  refuses({"--link", "trace", "--trace-up", folder_ / "none", "--trace-down", folder_ / "none"}, {"none"});
  refuses({"--occlusion", "maybe"}, {"--occlusion", "maybe"});
  refuses({"--viewers", "4,0"}, {"--viewers", "0"});
  refuses({"--viewers", "4,8", "--most-viewers"}, {"--most-viewers", "--viewers"});
  refuses({"--viewers", "4,8", "--real"}, {"--real", "2", "--viewers"});
}

TEST(ShippedExperiments, AreUsable) {
  size_t files = 0;
  for (const auto& entry : std::filesystem::directory_iterator(FORELAND_SOURCE_DIR "/lab/experiments")) {
    const ProgramResult result = runProgram("bench", {"run", entry.path().string(), "--check"});
    EXPECT_EQ(result.exit_code, 0) << entry.path() << result.output;
    ++files;
  }
  EXPECT_GE(files, 4u);
}

TEST_F(ExperimentProgram, SaysWhatAReportLacks) {
  expectRefusal("bench", {"report", folder_ / "nothing"}, {"results.json", "--out"});
  std::ofstream(folder_ / "results.json") << "{}";
  expectRefusal("bench", {"report", folder_.path(), "--sources", folder_.path()}, {"npm ci --prefix"});
}

TEST_F(ExperimentProgram, KeepsTheTableOfAFlightOverTiles) {
  const auto table = [&](const std::string& out) {
    const ProgramResult result =
        runProgram("bench", {"drape", scene(), "--layer", "relief", "--tour", "orbit", "--seconds", "1",
                             "--judge-every", "1", "--width", "160", "--height", "90", "--out", folder_ / out});
    EXPECT_EQ(result.exit_code, 0) << result.output;
    EXPECT_TRUE(std::filesystem::exists(folder_ / (out + "/results.json")));
    return slurp(folder_ / (out + "/results.csv"));
  };
  const std::vector<char> first = table("one");
  EXPECT_EQ(std::count(first.begin(), first.end(), '\n'), 7) << "a header and six ways";
  EXPECT_EQ(first, table("two"));
}

}  // namespace
}  // namespace foreland::test
