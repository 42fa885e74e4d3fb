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
  const auto files = [&](const std::string& out, const std::string& threads) {
    const ProgramResult result =
        runProgram("bench", {"latency",       scene(),  "--seconds",    "1",          "--width",      "160",
                             "--height",      "90",     "--strategies", "predict",    "--predictors", "velocity",
                             "--round-trips", "50,100", "--links",      "fixed,wifi", "--out",        folder_ / out,
                             "--threads",     threads});
    EXPECT_EQ(result.exit_code, 0) << result.output;
    std::vector<std::vector<char>> all;
    for (const char* name : {"results.csv", "results.json", "frames.csv", "keyframes.csv"})
      all.push_back(slurp(folder_ / (out + "/" + name)));
    return all;
  };
  const auto first = files("a", "1");
  for (const auto& file : first) EXPECT_GT(file.size(), 200u);
  EXPECT_EQ(first, files("b", "2"));
}

TEST_F(ExperimentProgram, SaysWhatAReportLacks) {
  expectRefusal("bench", {"report", folder_ / "nothing"}, {"results.json", "--out"});
  std::ofstream(folder_ / "results.json") << "{}";
  expectRefusal("bench", {"report", folder_.path(), "--sources", folder_.path()}, {"npm ci --prefix"});
}

}  // namespace
}  // namespace foreland::test
