// Programs of the user's in runs in virtual time: the examples are our own balancer, order, predictor and link to the
// byte, and a program that fails ends the run with words.
#include <gtest/gtest.h>

#include <fstream>
#include <map>

#include "lab/external/asked_program.h"
#include "lab/load/experiment.h"
#include "tests/apps/expect_refusal.h"
#include "tests/support/scene.h"
#include "tests/support/seed.h"

namespace foreland::lab {
namespace {

std::string example(const std::string& name) {
  return "python3 -B " FORELAND_SOURCE_DIR "/examples/instrument/" + name + ".py";
}

std::shared_ptr<const server::World> smallWorld() {
  static const auto world = std::make_shared<server::World>(test::makeScene(129, 129, 5));
  return world;
}

// Keyframes of different work, which often wait for each other.
LoadOptions crowdedLoad() {
  LoadOptions options;
  options.viewers = 20;
  options.workers = 2;
  options.run_in_s = 1.5;
  options.seconds = 1.5;
  options.tau_px = 20;
  options.phases = Phases::kRandom;
  options.prices = {"test", 10e6, 5000, 0, 0, 0, 0};
  options.seed = test::randomSeed();
  return options;
}

using Files = std::map<std::string, std::string>;

// All that a report has of the run, but what the way is called.
Files filesOf(const LoadOptions& options) {
  const LoadRun run = runLoad(smallWorld(), options);
  EXPECT_TRUE(run.status.ok()) << run.status.error().message;
  CellTables tables = tablesOf(run);
  for (const char* called : {"policy", "balance"}) tables.row.erase(called);
  Files files(tables.rows.begin(), tables.rows.end());
  files["row"] = tables.row.dump();
  return files;
}

// Which of the files differ; their bytes are too many to be shown.
std::vector<std::string> differing(const Files& a, const Files& b) {
  EXPECT_EQ(a.size(), b.size());
  std::vector<std::string> names;
  for (const auto& [name, text] : a)
    if (!b.contains(name) || b.at(name) != text) names.push_back(name);
  return names;
}
const std::vector<std::string> kNone;

TEST(Instrument, TheExampleBalancerIsLeastLoaded) {
  LoadOptions options = crowdedLoad();
  options.start = LoadStart::kEarly;
  options.cluster = {.servers = 3, .balance = Balance::kLeastLoaded, .events = {{ServerEvent::What::kFail, 1, 1.2}}};
  const auto own = filesOf(options);
  options.cluster.balance = Balance::kRoundRobin;
  const auto other = filesOf(options);
  options.cluster.balance_command = example("balance");
  EXPECT_EQ(differing(filesOf(options), own), kNone);
  EXPECT_NE(differing(other, own), kNone);
}

TEST(Instrument, TheExampleOrderIsLeastLaxity) {
  LoadOptions options = crowdedLoad();
  options.policy = LoadPolicy::kLeastLaxity;
  const auto own = filesOf(options);
  options.policy = LoadPolicy::kFair;
  const auto other = filesOf(options);
  options.order_command = example("order");
  EXPECT_EQ(differing(filesOf(options), own), kNone);
  EXPECT_NE(differing(other, own), kNone);
}

TEST(Instrument, TheExamplePredictorIsVelocity) {
  LoadOptions options = crowdedLoad();
  options.tau_px = 4;
  const auto own = filesOf(options);
  options.predictor = proto::Predictor::kHold;
  const auto other = filesOf(options);
  options.predictor_command = example("predictor");
  EXPECT_EQ(differing(filesOf(options), own), kNone);
  EXPECT_NE(differing(other, own), kNone);
}

TEST(Instrument, TheExampleLinkIsFixed) {
  LoadOptions options = crowdedLoad();
  const auto own = filesOf(options);
  options.links = sim::linkNamed("wifi")->links();
  const auto other = filesOf(options);
  options.link_command = example("link");
  EXPECT_EQ(differing(filesOf(options), own), kNone);
  EXPECT_NE(differing(other, own), kNone);
}

class InstrumentFailure : public testing::Test {
 protected:
  // A program that answers the first question with `greeting` and every other one by what `rest` does in Python.
  std::string program(const std::string& greeting, const std::string& rest) const {
    std::ofstream(folder_ / "p.py") << "import os, sys, time\nsys.stdin.readline()\nprint('" << greeting
                                    << "', flush=True)\nfor line in sys.stdin:\n    " << rest << "\n";
    return "python3 -B " + std::string(folder_ / "p.py");
  }
  std::string failureOf(const LoadOptions& options) const {
    const LoadRun run = runLoad(smallWorld(), options);
    return run.status.ok() ? "" : run.status.error().message;
  }
  // Of a balancer that says this of every viewer.
  std::string failureOfPlacing(const std::string& greeting, const std::string& rest) const {
    LoadOptions options = crowdedLoad();
    options.cluster = {.servers = 3, .events = {{ServerEvent::What::kJoin, 2, 2.5}}};
    options.cluster.balance_command = program(greeting, rest);
    return failureOf(options);
  }
  void expectWords(const std::string& message, const std::vector<std::string>& words) const {
    for (const std::string& word : words)
      EXPECT_NE(message.find(word), std::string::npos) << word << " is not in: " << message;
  }
  const std::string greeting_ = "{\"foreland\": 1}";
  test::TemporaryFolder folder_;
};

TEST_F(InstrumentFailure, NamesCommandAnswerAndWayOut) {
  const std::vector<std::string> always{"--balance-command '", "p.py'", "docs/INSTRUMENT.md"};
  const auto refuses = [&](const std::string& rest, std::vector<std::string> words) {
    words.insert(words.end(), always.begin(), always.end());
    expectWords(failureOfPlacing(greeting_, rest), words);
  };
  refuses("print('no', flush=True)", {"answer 2: 'no'", "no JSON object"});
  refuses("print('[0]', flush=True)", {"answer 2: '[0]'", "no JSON object"});
  refuses("print('{}', flush=True)", {"\"server\" must be a whole number from 0 to 2"});
  refuses("print('{\"server\": 1.5}', flush=True)", {"\"server\" must be"});
  refuses("print('{\"server\": 3}', flush=True)", {"\"server\" must be"});
  refuses("print('{\"server\": 18446744073709551615}', flush=True)", {"\"server\" must be"});
  refuses("print('{\"server\": 2}', flush=True)", {"server 2 takes no viewers"});
  refuses("sys.exit(3)", {"answer 2: it has ended, with code 3"});
  refuses("os.kill(os.getpid(), 9)", {"answer 2: it was ended by signal 9"});
  expectWords(failureOfPlacing("{\"foreland\": 7}", "pass"), {"answer 1", "{\"foreland\": 1}, the version"});
}

TEST_F(InstrumentFailure, OfEveryRoleEndsTheRun) {
  LoadOptions options = crowdedLoad();
  options.order_command = program(greeting_, "print('{\"key\": \"soon\"}', flush=True)");
  expectWords(failureOf(options), {"--order-command", "\"key\" must be a whole number"});
  options.order_command.clear();
  options.link_command = program(greeting_, "print('{\"leaves_us\": -1, \"arrives_us\": 0}', flush=True)");
  expectWords(failureOf(options), {"--link-command", "\"leaves_us\" must be a whole number"});
  options.link_command.clear();
  const std::string motion = "\"velocity_m_s\": [0, 0, 0], \"acceleration_m_s2\": [0, 0, 0], ";
  options.predictor_command =
      program(greeting_, "print('{" + motion + "\"rotation\": [2, 0, 0, 0], \"span_s\": 1}', flush=True)");
  expectWords(failureOf(options), {"--predictor-command", "unit length"});
  options.predictor_command =
      program(greeting_, "print('{" + motion + "\"rotation\": [1, 0, 0, 0], \"span_s\": 0}', flush=True)");
  expectWords(failureOf(options), {"\"span_s\" must be a number"});
  options.predictor_command = program(greeting_, "print('{\"velocity_m_s\": [0, 0, NaN]}', flush=True)");
  expectWords(failureOf(options), {"--predictor-command"});
  options.predictor_command = folder_ / "none.py";
  expectWords(failureOf(options), {"none.py' cannot be run", "No such file"});
}

TEST_F(InstrumentFailure, OfAProgramThatHangsIsNoticed) {
  const auto started = [&](const std::string& rest) {
    std::ofstream(folder_ / "p.sh") << "read line\necho '" << greeting_ << "'\n" << rest << "\n";
    const std::string command = "sh " + std::string(folder_ / "p.sh");
    auto program = AskedProgram::start({"--link-command", "link"}, command, 1, Duration::milliseconds(5000));
    EXPECT_TRUE(program.ok());
    return std::move(*program);
  };
  const auto silent = started("exec sleep 1000");
  const auto answer = silent->ask({{"ask", "carry"}});
  ASSERT_FALSE(answer.ok());
  expectWords(answer.error().message, {"answer 2: there is no answer within 5 s", "flush"});
  EXPECT_EQ(silent->ask({{"ask", "carry"}}).error().message, answer.error().message);

  const auto deaf = started("exec sleep 1000");
  EXPECT_FALSE(deaf->ask({{"much", std::string(8 << 20, 'x')}}).ok());
  expectWords(deaf->status().error().message, {"does not read"});

  const auto endless = started("exec head -c 3000000 /dev/zero");
  EXPECT_FALSE(endless->ask({{"ask", "carry"}}).ok());
  expectWords(endless->status().error().message, {"no end"});
}

class InstrumentProgram : public testing::Test {
 protected:
  void SetUp() override {
    test::FormulaSource source(129, 129,
                               [](uint32_t x, uint32_t y) { return 40 * std::sin(0.1 * x) * std::cos(0.13 * y); });
    ASSERT_TRUE(terrain::buildScene(source, {folder_ / "scene.fls", 0.1, 1}).ok());
  }
  std::vector<std::string> latency(const std::string& out, const std::string& predictor) const {
    return {"latency",
            folder_ / "scene.fls",
            "--seconds",
            "1",
            "--width",
            "160",
            "--height",
            "90",
            "--strategies",
            "predict",
            "--predictors",
            "velocity",
            "--out",
            folder_ / out,
            "--predictor-command",
            predictor,
            "--link-command",
            example("link"),
            "--round-trips",
            "50"};
  }
  test::TemporaryFolder folder_;
};

// The rows of the strangers' are those of ours, but for their names.
TEST_F(InstrumentProgram, WritesTheSameFilesTwiceAndTheSameRowsForBoth) {
  const auto files = [&](const std::string& out) {
    const test::ProgramResult result = test::runProgram("bench", latency(out, example("predictor")));
    EXPECT_EQ(result.exit_code, 0) << result.output;
    std::map<std::string, std::vector<char>> all;
    for (const char* name : {"results.csv", "results.json", "frames.csv", "keyframes.csv"})
      all[name] = test::slurp(folder_ / (out + "/" + name));
    return all;
  };
  const auto first = files("a");
  EXPECT_EQ(first, files("b"));
  const auto json = nlohmann::ordered_json::parse(first.at("results.json"));
  ASSERT_EQ(json["cells"].size(), 4u);
  for (auto row : json["cells"]) {
    auto own = json["cells"][0];
    for (const char* name : {"predictor", "link", "round_trip_ms"}) row.erase(name), own.erase(name);
    EXPECT_EQ(row.dump(), own.dump());
  }
  EXPECT_EQ(json["cells"][3]["predictor"].get<std::string>(), example("predictor"));
}

TEST_F(InstrumentProgram, LeavesNothingOfARunWhoseProgramFails) {
  const test::ProgramResult result = test::runProgram("bench", latency("out", "false"));
  EXPECT_NE(result.exit_code, 0);
  EXPECT_NE(result.output.find("--predictor-command 'false', answer 1: it has ended, with code 1"), std::string::npos)
      << result.output;
  EXPECT_FALSE(std::filesystem::exists(folder_ / "out"));
}

}  // namespace
}  // namespace foreland::lab
