// The dictionary of results (docs/RESULTS.md) against the tables that experiments really write: every column is in it
// with its type, and none that is not written.
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <map>
#include <regex>
#include <set>
#include <sstream>

#include "tests/apps/expect_refusal.h"
#include "tests/support/scene.h"

namespace foreland::test {
namespace {

using Columns = std::map<std::string, std::string>;  // types by name

// `a_{b,c}` is a_b and a_c.
std::vector<std::string> expanded(const std::string& name) {
  const size_t begin = name.find('{'), end = name.find('}');
  if (begin == std::string::npos) return {name};
  std::vector<std::string> all;
  std::stringstream inside(name.substr(begin + 1, end - begin - 1));
  for (std::string word; std::getline(inside, word, ',');)
    for (const std::string& rest : expanded(name.substr(end + 1))) all.push_back(name.substr(0, begin) + word + rest);
  return all;
}

// By `experiment/table`.
std::map<std::string, Columns> dictionary() {
  std::ifstream file(FORELAND_SOURCE_DIR "/docs/RESULTS.md");
  const std::regex heading("## (\\w+): `(\\w+\\.csv)`"), row("\\| (`.*`) \\| (text|whole|real) \\| .*"),
      name("`([^`]+)`");
  std::map<std::string, Columns> all;
  std::string at;
  for (std::string line; std::getline(file, line);) {
    std::smatch found;
    if (std::regex_match(line, found, heading)) at = found[1].str() + "/" + found[2].str();
    if (!std::regex_match(line, found, row)) continue;
    const std::string names = found[1], type = found[2];
    for (auto it = std::sregex_iterator(names.begin(), names.end(), name); it != std::sregex_iterator(); ++it)
      for (const std::string& column : expanded((*it)[1])) EXPECT_TRUE(all[at].emplace(column, type).second) << column;
  }
  return all;
}

std::vector<std::string> cellsOf(const std::string& line) {
  std::vector<std::string> cells(1);
  bool is_quoted = false;
  for (const char c : line) {
    if (c == '"') is_quoted = !is_quoted;
    if (c == ',' && !is_quoted) cells.emplace_back();
    if (c != '"' && (c != ',' || is_quoted)) cells.back() += c;
  }
  return cells;
}

bool isOf(const std::string& type, const std::string& text) {
  if (type == "text") return !text.empty();
  if (type == "whole") return std::regex_match(text, std::regex("-?[0-9]+"));
  char* end = nullptr;
  const double value = std::strtod(text.c_str(), &end);
  return !text.empty() && *end == '\0' && !std::isnan(value);
}

class Results : public testing::Test {
 protected:
  void SetUp() override {
    FormulaSource source(129, 129, [](uint32_t x, uint32_t y) { return 40 * std::sin(0.1 * x) * std::cos(0.13 * y); });
    ASSERT_TRUE(terrain::buildScene(source, {scene_, 0.1, 1}).ok());
  }
  void run(const std::vector<std::string>& arguments) const {
    const ProgramResult result = runProgram("bench", arguments);
    ASSERT_EQ(result.exit_code, 0) << result.output;
  }
  // Compares what the folder has with the dictionary, and takes what it finds out of `unseen`.
  void compare(const std::string& experiment, const std::string& folder, std::map<std::string, Columns>& unseen) const {
    static const auto all = dictionary();
    for (const auto& entry : std::filesystem::directory_iterator(folder_ / folder)) {
      if (entry.path().extension() != ".csv") continue;
      const std::string table = experiment + "/" + entry.path().filename().string();
      ASSERT_TRUE(all.contains(table)) << table << " is not in docs/RESULTS.md";
      compareTable(entry.path(), table, all.at(table), unseen[table]);
    }
  }
  static void compareTable(const std::filesystem::path& path, const std::string& table, const Columns& columns,
                           Columns& unseen) {
    std::ifstream file(path);
    std::string line;
    std::getline(file, line);
    const std::vector<std::string> header = cellsOf(line);
    EXPECT_EQ(std::set<std::string>(header.begin(), header.end()).size(), header.size()) << table << ": " << line;
    for (const std::string& name : header) {
      EXPECT_TRUE(columns.contains(name)) << name << " of " << table << " is not in docs/RESULTS.md";
      unseen.erase(name);
    }
    for (size_t row = 1; std::getline(file, line); ++row) {
      const std::vector<std::string> cells = cellsOf(line);
      ASSERT_EQ(cells.size(), header.size()) << table << ": " << line;
      for (size_t i = 0; i < cells.size(); ++i)
        if (columns.contains(header[i])) {
          EXPECT_TRUE(isOf(columns.at(header[i]), cells[i]))
              << header[i] << " of " << table << ", row " << row << ": '" << cells[i] << "'";
        }
    }
  }

  TemporaryFolder folder_;
  const std::string scene_ = folder_ / "scene.fls";
};

TEST_F(Results, HaveTheColumnsOfTheDictionary) {
  const std::string latency = folder_ / "latency", load = folder_ / "load", servers = folder_ / "servers",
                    tiles = folder_ / "tiles";
  run({"latency", scene_, "--seconds", "1", "--width", "160", "--height", "90", "--strategies", "predict,current",
       "--predictors", "velocity", "--round-trips", "50", "--out", latency});
  run({"load", scene_, "--viewers", "2,4", "--seconds", "1", "--policies", "edf", "--phases", "random", "--out", load});
  run({"load", scene_, "--viewers", "4,6", "--servers", "2", "--balance", "migrate", "--seconds", "2", "--fail",
       "1@0.5", "--out", servers});
  run({"tiles", scene_, "--seconds", "2", "--width", "160", "--height", "90", "--out", tiles});
  run({"cost", tiles});
  auto unseen = dictionary();
  ASSERT_EQ(unseen.size(), 13u);
  compare("latency", "latency", unseen);
  compare("load", "load", unseen);
  compare("load", "servers", unseen);
  compare("tiles", "tiles", unseen);
  for (const auto& [table, columns] : unseen)
    for (const auto& [name, type] : columns) ADD_FAILURE() << name << " of " << table << " is never written";
}

// A figure of the table, whose bytes are the table's alone.
TEST_F(Results, CanBeDrawn) {
  run({"latency", scene_, "--seconds", "1", "--width", "160", "--height", "90", "--strategies", "delay,current",
       "--round-trips", "0,100", "--out", folder_ / "latency"});
  const auto draws = [&](const std::string& table, const std::string& columns, const std::string& out) {
    return std::system(("python3 -B " FORELAND_SOURCE_DIR "/tools/redraw.py " + std::string(folder_ / "latency/") +
                        table + columns + " -o " + std::string(folder_ / out) + " 2> " + std::string(folder_ / "said"))
                           .c_str());
  };
  for (const char* out : {"a.svg", "b.svg"}) {
    EXPECT_EQ(draws("results.csv", " --x round_trip_ms --y total_p99_px --by strategy --log", out), 0);
    EXPECT_EQ(
        draws("frames.csv", " --x time_s --y total_max_px --by strategy,round_trip_ms", "frames_" + std::string(out)),
        0);
  }
  EXPECT_EQ(slurp(folder_ / "a.svg"), slurp(folder_ / "b.svg"));
  EXPECT_EQ(slurp(folder_ / "frames_a.svg"), slurp(folder_ / "frames_b.svg"));
  EXPECT_NE(draws("results.csv", " --x round_trip_ms --y beauty", "none.svg"), 0);
  const auto said = slurp(folder_ / "said");
  EXPECT_NE(std::string(said.begin(), said.end()).find("no column 'beauty'"), std::string::npos);
}

// The commands that draw the published figures again name columns that there are.
TEST(ResultsDictionary, HasWhatTheFiguresAreDrawnOf) {
  std::map<std::string, std::set<std::string>> columns;  // by table, whatever the experiment
  for (const auto& [table, of] : dictionary())
    for (const auto& [name, type] : of) columns[table.substr(table.find('/') + 1)].insert(name);
  std::ifstream file(FORELAND_SOURCE_DIR "/docs/RESULTS.md");
  const std::regex command("    tools/redraw\\.py \\S*/(\\w+\\.csv) --x \\w+.*"), named("--(?:x|y|by|where) ([\\w,]+)");
  size_t figures = 0;
  for (std::string line; std::getline(file, line);) {
    std::smatch found;
    if (!std::regex_match(line, found, command)) continue;
    ++figures;
    const std::string table = found[1];
    for (auto it = std::sregex_iterator(line.begin(), line.end(), named); it != std::sregex_iterator(); ++it) {
      std::stringstream names((*it)[1]);
      for (std::string name; std::getline(names, name, ',');)
        EXPECT_TRUE(columns[table].contains(name) || columns["results.csv"].contains(name)) << name << ": " << line;
    }
  }
  EXPECT_GE(figures, 7u);
}

}  // namespace
}  // namespace foreland::test
