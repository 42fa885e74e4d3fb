// How programs read their command lines: what ends them at once, and with which words.
#include "apps/options/command_line.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "apps/options/options.h"

namespace foreland::apps {
namespace {

struct Outcome {
  std::optional<int> exit_code;
  std::string output, errors;
  double tau_px = 1;
};

// Of a program with one option that must be given, one with a range, and a subcommand.
Outcome parse(std::vector<const char*> words) {
  Outcome outcome;
  std::string scene, model;
  CLI::App app("Does this.", "foreland test");
  app.add_option("--scene", scene, "a scene")->type_name(file("SCENE.fls"))->required();
  app.add_option("--tau", outcome.tau_px, "largest error")->type_name(number("PX"))->check(within(0.01, 1000.0));
  app.add_subcommand("below", "is below")->add_option("--model", model, "a model")->check(oneOf({"x", "y"}));
  words.insert(words.begin(), "foreland-test");
  testing::internal::CaptureStdout();
  testing::internal::CaptureStderr();
  outcome.exit_code =
      parseCommandLine(app, static_cast<int>(words.size()), words.data(), {{"this", "foreland test --scene a.fls"}});
  outcome.output = testing::internal::GetCapturedStdout();
  outcome.errors = testing::internal::GetCapturedStderr();
  return outcome;
}

TEST(CommandLine, GoesOnIfAllIsRight) {
  const Outcome outcome = parse({"--scene", "a.fls", "--tau", "2"});
  EXPECT_EQ(outcome.exit_code, std::nullopt);
  EXPECT_EQ(outcome.tau_px, 2);
  EXPECT_EQ(outcome.output + outcome.errors, "");
}

TEST(CommandLine, EndsWithZeroAfterHelp) {
  for (const char* help : {"--help", "-h"}) {
    const Outcome outcome = parse({help});
    EXPECT_EQ(outcome.exit_code, 0);
    EXPECT_TRUE(outcome.output.starts_with("Does this.\n\nusage: foreland test --scene SCENE.fls [OPTION]..."))
        << outcome.output;
    EXPECT_NE(outcome.output.find("foreland test --scene a.fls\n"), std::string::npos) << "the example";
    EXPECT_EQ(outcome.errors, "");
  }
}

TEST(CommandLine, HelpOfASubcommandIsItsOwn) {
  const Outcome outcome = parse({"below", "--help"});
  EXPECT_EQ(outcome.exit_code, 0);
  EXPECT_TRUE(outcome.output.starts_with("is below\n\nusage: foreland test below [OPTION]...")) << outcome.output;
  EXPECT_NE(outcome.output.find("--model x|y"), std::string::npos);
  EXPECT_EQ(outcome.output.find("Examples"), std::string::npos) << "which are the program's";
}

TEST(CommandLine, EndsWithTwoAfterAMistakeAndSaysWhatToDo) {
  const std::pair<std::vector<const char*>, std::string> cases[] = {
      {{}, "foreland test: --scene is required (see foreland test --help)\n"},
      {{"--scene"}, "foreland test: --scene needs a value (see foreland test --help)\n"},
      {{"--scene", "a", "--tau", "0"},
       "foreland test: --tau: '0' is not a number of 0.01 to 1000 (see foreland test --help)\n"},
      {{"--scene", "a", "below", "--model", "z"},
       "foreland test below: --model: 'z' is not one of x, y (see foreland test below --help)\n"}};
  for (const auto& [words, message] : cases) {
    const Outcome outcome = parse(words);
    EXPECT_EQ(outcome.exit_code, 2);
    EXPECT_EQ(outcome.errors, message);
    EXPECT_EQ(outcome.output, "");
  }
}

TEST(CommandLine, PrintsItsOptionsForTheManual) {
  const Outcome outcome = parse({"--options-as-json"});
  EXPECT_EQ(outcome.exit_code, 0);
  EXPECT_EQ(nlohmann::json::parse(outcome.output)["name"], "foreland test");
  EXPECT_EQ(parse({"--scene", "a", "--options-as-json"}).exit_code, 2) << "but alone";
}

}  // namespace
}  // namespace foreland::apps
