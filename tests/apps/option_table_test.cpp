// The table of options: what is read from CLI11's description of them, and what --help and the JSON say of it.
#include "apps/options/option_table.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <sstream>

#include "apps/options/options.h"

namespace foreland::apps {
namespace {

struct Values {
  double tau_px = 1, hours = 0;
  int levels = 4;
  std::string frame, name, interval = "200";
  std::filesystem::path scene, output;
  std::vector<std::filesystem::path> pictures;
  std::vector<std::string> epochs, links;
  bool json = false;
};

void describe(CLI::App& app, Values& v) {
  app.add_option("SCENE", v.scene, "a scene")->type_name(file("SCENE.fls"))->required();
  app.add_option("-o,--output", v.output, "where it goes")->type_name(folder("DIR"))->required();
  app.add_option("--tau", v.tau_px, "largest error")
      ->type_name(number("PX"))
      ->check(within(0.01, 1000.0))
      ->capture_default_str()
      ->group("Detail");
  app.add_option("--hours", v.hours, "until then")->type_name(number("H"))->check(above(0));
  app.add_option("--levels", v.levels, "levels")->check(within(1, 12))->capture_default_str();
  app.add_option("--frame", v.frame, "the frame")->check(oneOf({"auto", "planar"}))->default_str("auto");
  app.add_option("--name", v.name, "whose it is")->type_name(text("A:B"))->check(oneOf({"x", "y"}));
  app.add_option("--interval", v.interval, "how often")->type_name(numberOrText("MS"));
  CLI::Option* pictures = app.add_option("--picture", v.pictures, "pictures")->type_name(file("FILE"));
  app.add_option("--epoch", v.epochs, "a date")->type_name(text("DATE=FILE"))->allow_extra_args(false);
  app.add_option("--link", v.links, "links")->delimiter(',')->needs(pictures);
  app.add_flag("--json", v.json, "print JSON")->excludes("--tau")->excludes("--epoch");
  app.add_option("--secret", v.name, "that nobody is told of")->group("");
}

class OptionTable : public testing::Test {
 protected:
  OptionTable() { describe(app_, values_); }
  OptionRow row(const std::string& name) {
    for (const OptionRow& row : optionTable(app_))
      if (row.names.back() == name) return row;
    ADD_FAILURE() << name << " is not in the table";
    return {};
  }

  CLI::App app_{"Does this.", "foreland test"};
  Values values_;
};

TEST_F(OptionTable, HasNamesAndKindsInOrder) {
  std::vector<std::string> names;
  for (const OptionRow& row : optionTable(app_)) names.push_back(row.names.back());
  EXPECT_EQ(names, (std::vector<std::string>{"SCENE", "--output", "--tau", "--hours", "--levels", "--frame", "--name",
                                             "--interval", "--picture", "--epoch", "--link", "--json"}));
  EXPECT_EQ(row("SCENE").kind, ValueKind::kFile);
  EXPECT_TRUE(row("SCENE").is_positional);
  EXPECT_EQ(row("--output").names, (std::vector<std::string>{"-o", "--output"}));
  EXPECT_EQ(row("--output").kind, ValueKind::kFolder);
  EXPECT_EQ(row("--tau").kind, ValueKind::kNumber);
  EXPECT_EQ(row("--levels").kind, ValueKind::kWhole) << "by its type";
  EXPECT_EQ(row("--interval").kind, ValueKind::kNumberOrText);
  EXPECT_EQ(row("--json").kind, ValueKind::kNone);
  EXPECT_EQ(row("--name").kind, ValueKind::kText);
}

TEST_F(OptionTable, KnowsWhatValuesMayBe) {
  EXPECT_EQ(row("--tau").least, 0.01);
  EXPECT_EQ(row("--tau").most, 1000);
  EXPECT_EQ(row("--tau").above, std::nullopt);
  EXPECT_EQ(row("--tau").default_value, "1");
  EXPECT_EQ(row("--hours").above, 0);
  EXPECT_EQ(row("--hours").most, std::nullopt);
  EXPECT_EQ(row("--frame").words, (std::vector<std::string>{"auto", "planar"}));
  EXPECT_EQ(row("--frame").value, "auto|planar");
  EXPECT_EQ(row("--name").value, "A:B") << "a name of its own goes before the words";
}

TEST_F(OptionTable, KnowsHowOftenAnOptionMayBeGiven) {
  EXPECT_FALSE(row("--tau").is_repeatable);
  EXPECT_TRUE(row("--picture").is_repeatable);
  EXPECT_TRUE(row("--picture").takes_many_at_once);
  EXPECT_TRUE(row("--epoch").is_repeatable);
  EXPECT_FALSE(row("--epoch").takes_many_at_once);
  EXPECT_EQ(row("--link").delimiter, ',');
}

TEST_F(OptionTable, SaysInFactsWhatDescriptionsDoNot) {
  EXPECT_EQ(factsOf(row("--tau")), "0.01 to 1000; default 1; not with --json");
  EXPECT_EQ(factsOf(row("--hours")), "above 0");
  EXPECT_EQ(factsOf(row("--frame")), "default auto") << "its words stand in the place of the value";
  EXPECT_EQ(factsOf(row("--name")), "x, y");
  EXPECT_EQ(factsOf(row("--epoch")), "may be repeated; not with --json");
  EXPECT_EQ(factsOf(row("--link")), "several with commas between; with --picture");
  EXPECT_EQ(factsOf(row("--json")), "not with --epoch or --tau");
}

TEST_F(OptionTable, UsageNamesWhatMustBeGiven) {
  EXPECT_EQ(usageOf(optionTable(app_), "foreland test"), "foreland test SCENE -o DIR [OPTION]...");
}

TEST_F(OptionTable, HelpFitsOneHundredColumnsAndHidesNothingButSecrets) {
  app_.get_option("--tau")->description(
      "a description that goes on and on, for so long that it needs several lines of "
      "the screen, each of which begins where the first one begins");
  const std::string help = helpText(app_, "foreland test", std::vector<Example>{{"this", "foreland test a.fls"}});
  std::istringstream lines(help);
  for (std::string line; std::getline(lines, line);) EXPECT_LE(line.size(), 100u) << line;
  for (const char* words :
       {"Does this.\n\nusage: foreland test SCENE -o DIR [OPTION]...\n", "\nDetail\n      --tau PX ",
        "  -o, --output DIR              where it goes\n", "[0.01 to 1000; default 1; not with --json]",
        "\n  -h, --help ", "\nExamples\n  this\n      foreland test a.fls\n"})
    EXPECT_NE(help.find(words), std::string::npos) << words << " is not in:\n" << help;
  EXPECT_EQ(help.find("--secret"), std::string::npos);
}

TEST_F(OptionTable, JsonHasTheTableAndThoseOfSubcommands) {
  CLI::App* sub = app_.add_subcommand("below", "is below");
  sub->add_flag("--deep", values_.json, "goes deep");
  const auto json = nlohmann::json::parse(optionsAsJson(app_, std::vector<Example>{{"this", "foreland test a.fls"}}));
  EXPECT_EQ(json["name"], "foreland test");
  EXPECT_EQ(json["options"].size(), 12u);
  EXPECT_EQ(json["options"][2]["names"], nlohmann::json::array({"--tau"}));
  EXPECT_EQ(json["options"][2]["least"], 0.01);
  EXPECT_EQ(json["options"][2]["group"], "Detail");
  EXPECT_TRUE(json["options"][4]["most"].is_number_integer()) << "whole numbers have whole bounds";
  EXPECT_EQ(json["examples"][0]["command"], "foreland test a.fls");
  EXPECT_EQ(json["subcommands"][0]["name"], "foreland test below");
  EXPECT_EQ(json["subcommands"][0]["options"][0]["type"], "flag");
}

TEST(Checks, NumbersAreReadBackAsTheyWereMeant) {
  for (const double value : {0.0, 0.01, -5.0, 1e-7, 1.0 / 3, 100'000'000.0, 1e300, 86'400.0, 0.1 + 0.2})
    EXPECT_EQ(finiteNumber(plainDigits(value)), value) << plainDigits(value);
  EXPECT_EQ(plainDigits(100'000'000), "100000000");
  EXPECT_EQ(plainDigits(0.001), "0.001");
}

TEST(Checks, RangesHoldTheirEndsAndNothingBeyondThem) {
  const CLI::Validator whole = within(1, 12), any = within(0.5, 2.0), open = above(0, 10);
  for (const char* right : {"1", "12"}) EXPECT_EQ(whole(std::string(right)), "") << right;
  for (const char* wrong : {"0", "13", "1.5", "nan", "inf", "", "x", "1x", "99999999999999999999"})
    EXPECT_NE(whole(std::string(wrong)), "") << wrong;
  for (const char* right : {"0.5", "2", "1e0"}) EXPECT_EQ(any(std::string(right)), "") << right;
  for (const char* wrong : {"0.49", "2.01", "nan", "-inf", "", "1 "}) EXPECT_NE(any(std::string(wrong)), "") << wrong;
  for (const char* right : {"0.0001", "10"}) EXPECT_EQ(open(std::string(right)), "") << right;
  for (const char* wrong : {"0", "-1", "10.1", "nan", "inf"}) EXPECT_NE(open(std::string(wrong)), "") << wrong;
}

TEST(Checks, WordsAreTakenAsTheyAreWritten) {
  const CLI::Validator check = oneOf({"on", "off"});
  EXPECT_EQ(check(std::string("on")), "");
  EXPECT_EQ(check(std::string("ON")), "'ON' is not one of on, off");
  EXPECT_NE(check(std::string("on|off")), "");
}

}  // namespace
}  // namespace foreland::apps
