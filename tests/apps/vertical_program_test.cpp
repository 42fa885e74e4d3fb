// Vertical datums as people meet them: `foreland build --vertical`, what `foreland info` says, its map, and
// `foreland heights`.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "terrain/model/png.h"
#include "tests/apps/expect_refusal.h"
#include "tests/support/scene.h"

namespace foreland::test {
namespace {

constexpr int kColumns = 70, kRows = 60;

double heightOf(double x, double y) { return 500 + x + 2 * y; }  // at the lattice; bilinear

class VerticalProgram : public testing::Test {
 protected:
  // Degrees from 8, 46 on, without a reference system that says so.
  std::string grid(const std::string& name, int first_column, int columns, double more = 0) const {
    std::ofstream out(folder_ / name);
    out << "ncols " << columns << "\nnrows " << kRows << "\nxllcenter " << 8 + 0.01 * first_column
        << "\nyllcenter 46\ncellsize 0.01\nNODATA_value -9999\n";
    for (int row = kRows - 1; row >= 0; --row)
      for (int x = first_column; x < first_column + columns; ++x)
        out << heightOf(x, row) + more << (x == first_column + columns - 1 ? '\n' : ' ');
    return folder_ / name;
  }
  std::string at(const std::string& name) const { return (folder_ / name).string(); }
  void build(const std::vector<std::string>& arguments, const std::string& name = "scene.fls") const {
    std::vector<std::string> all = arguments;
    all.insert(all.end(), {"--frame", "geographic", "-o", folder_ / name});
    const ProgramResult built = runProgram("build", all);
    ASSERT_EQ(built.exit_code, 0) << built.output;
  }
  nlohmann::json info(const std::string& name = "scene.fls") const {
    const auto json = nlohmann::json::parse(
        runProgram("info", {folder_ / name, "--json"}, {.streams = Streams::kOutputOnly}).output, nullptr, false);
    EXPECT_FALSE(json.is_discarded());
    return json;
  }
  // Lines of its output for lines of input.
  std::vector<std::string> heights(const std::string& input, int exit_code = 0,
                                   const std::string& name = "scene.fls") const {
    std::ofstream(folder_ / "points.csv") << input;
    const std::string command = std::string(FORELAND_BIN_DIR) + "/foreland-heights " + at(name) + " <" +
                                at("points.csv") + " >" + at("out.csv") + " 2>" + at("errors");
    const int status = std::system(command.c_str());
    EXPECT_EQ(WEXITSTATUS(status), exit_code);
    std::ifstream out(folder_ / "out.csv");
    std::vector<std::string> lines;
    for (std::string line; std::getline(out, line);) lines.push_back(line);
    return lines;
  }
  std::string errors() const {
    std::ifstream in(folder_ / "errors");
    return {std::istreambuf_iterator<char>(in), {}};
  }
  static std::vector<std::string> fields(const std::string& line) {
    std::vector<std::string> out(1);
    for (const char c : line) {
      if (c == ',')
        out.emplace_back();
      else
        out.back().push_back(c);
    }
    return out;
  }

  TemporaryFolder folder_;
};

TEST_F(VerticalProgram, InfoSaysWhatHeightsAreAbove) {
  build({grid("hills.asc", 0, kColumns)}, "unstated.fls");
  EXPECT_EQ(info("unstated.fls")["vertical"]["zero_surface"], "unstated");
  EXPECT_NE(runProgram("info", {folder_ / "unstated.fls"}).output.find("unstated"), std::string::npos);
  build({folder_ / "hills.asc", "--vertical", "egm96"});
  const auto vertical = info()["vertical"];
  EXPECT_EQ(vertical["zero_surface"], "sea level");
  EXPECT_EQ(vertical["name"], "EGM96");
  EXPECT_EQ(vertical["geoid"]["name"], "EGM96");
  EXPECT_NEAR(vertical["geoid"]["undulation_m"][0].get<double>(), 49, 4);
  EXPECT_EQ(vertical["inputs"][0]["name"], "hills.asc");
  EXPECT_EQ(runProgram("verify", {folder_ / "scene.fls"}).exit_code, 0);
}

TEST_F(VerticalProgram, OneInputMayHaveAnotherDatum) {
  const std::string west = grid("west.asc", 0, kColumns / 2), east = grid("east.asc", kColumns / 2, kColumns / 2);
  build({west, east + "@vertical=ellipsoid", "--vertical", "egm96"});
  const auto inputs = info()["vertical"]["inputs"];
  ASSERT_EQ(inputs.size(), 2u);
  EXPECT_EQ(inputs[0]["vertical"], "EGM96");
  EXPECT_EQ(inputs[1]["vertical"], "ellipsoid");
  const auto lines = heights("8.1,46.3\n8.5,46.3\n");
  ASSERT_EQ(lines.size(), 3u);
  EXPECT_NEAR(std::stod(fields(lines[1])[2]), heightOf(10, 30), 0.1);
  EXPECT_NEAR(std::stod(fields(lines[2])[4]), heightOf(50, 30), 0.1) << "above the ellipsoid it is as in the file";
  EXPECT_EQ(fields(lines[1])[5], "west.asc");
  EXPECT_EQ(fields(lines[2])[5], "east.asc");
}

TEST_F(VerticalProgram, HeightsAreExactAndByBothSurfaces) {
  build({grid("hills.asc", 0, kColumns), "--vertical", "egm96"});
  const auto lines = heights("lon,lat\n8.105,46.305\n\n# a remark\n8.69,46.59,what follows\n 8.0 , 46.0 \n7.9,46\n");
  ASSERT_EQ(lines.size(), 5u);
  EXPECT_EQ(lines[0], "longitude,latitude,height_m,above_sea_m,above_ellipsoid_m,source,residual_m");
  const auto first = fields(lines[1]);
  ASSERT_EQ(first.size(), 7u);
  EXPECT_NEAR(std::stod(first[2]), heightOf(10.5, 30.5), 1e-3) << "between four samples";
  EXPECT_EQ(first[2], first[3]);
  EXPECT_NEAR(std::stod(first[4]) - std::stod(first[3]), 49, 4);
  EXPECT_EQ(first[5], "hills.asc");
  EXPECT_EQ(first[6], "0.5") << "steps of 1 m are rounded by half of one at most";
  EXPECT_NEAR(std::stod(fields(lines[2])[2]), heightOf(69, 59), 1e-3) << "the last sample";
  EXPECT_NEAR(std::stod(fields(lines[3])[2]), heightOf(0, 0), 1e-3);
  EXPECT_EQ(lines[4], "7.900000000,46.000000000,,,,,") << "beyond the data";
}

TEST_F(VerticalProgram, HeightsOfAnUnstatedSceneAreOfNoSurface) {
  build({grid("hills.asc", 0, kColumns)});
  const auto lines = heights("8.1,46.3\n368.1,46.3\n");
  ASSERT_EQ(lines.size(), 3u);
  EXPECT_EQ(lines[1], "8.100000000,46.300000000,570.0000,,,hills.asc,");
  EXPECT_EQ(fields(lines[2])[2], "570.0000") << "a turn away";
}

TEST_F(VerticalProgram, HeightsNamesBadLinesAndAnswersTheOthers) {
  build({grid("hills.asc", 0, kColumns)});
  const auto lines = heights("8.1,46.3\nnowhere\n8.1\n8.1,97\nnan,46\n8.2,46.3\n", 2);
  EXPECT_EQ(lines.size(), 3u);
  for (const char* words :
       {"line 2: write longitude,latitude", "line 3: write", "line 4: the scene is geographic", "line 5: write"})
    EXPECT_NE(errors().find(words), std::string::npos) << words << " is not in " << errors();
  expectRefusal("heights", {folder_ / "none.fls"}, {"none.fls"});
  expectRefusal("heights", {folder_ / "scene.fls", "--date", "2000-01-01"}, {"does not change in time"});
}

TEST_F(VerticalProgram, WhatTheBuildCannotDoIsNamed) {
  const std::string hills = grid("hills.asc", 0, kColumns), scene = folder_ / "no.fls";
  expectRefusal("build", {hills, "-o", scene, "--vertical", "egm69"}, {"hills.asc", "egm69", "egm96"});
  expectRefusal("build", {hills + "@vertical=none.gtx", "-o", scene}, {"hills.asc", "none.gtx", "no such file"});
  expectRefusal("build", {hills, "-o", scene, "--vertical", "file"}, {"hills.asc", "does not say"});
  const ProgramResult doubted = runProgram(
      "build", {hills, grid("feet.asc", 0, kColumns, 1800), "--frame", "geographic", "-o", folder_ / "doubted.fls"});
  EXPECT_EQ(doubted.exit_code, 0);
  for (const char* word : {"warning:", "feet.asc", "do not agree where they overlap"})
    EXPECT_NE(doubted.output.find(word), std::string::npos) << word << " is not in " << doubted.output;
}

TEST_F(VerticalProgram, TheMapHasTheGroundAndTheInputsOutlines) {
  build({grid("west.asc", 0, kColumns / 2), grid("east.asc", kColumns / 2, kColumns / 2), "--vertical", "egm96"});
  const std::string file = folder_ / "map.png";
  const ProgramResult result =
      runProgram("info", {folder_ / "scene.fls", "--json", "--map", file}, {.streams = Streams::kOutputOnly});
  ASSERT_EQ(result.exit_code, 0) << result.output;
  const auto outlines = nlohmann::json::parse(result.output)["map"];
  ASSERT_EQ(outlines.size(), 2u);
  EXPECT_EQ(outlines[1]["name"], "east.asc");
  const auto image = terrain::readPng(file);
  ASSERT_TRUE(image.ok()) << image.error().message;
  EXPECT_NEAR(static_cast<double>(image->width) / image->height, 69 * std::cos(46.3 / 57.29577951308232) / 59, 0.05)
      << "as on the ground";
  const auto hexadecimal = [](const terrain::Colour& c) {
    char text[8];
    std::snprintf(text, sizeof text, "#%02x%02x%02x", c[0], c[1], c[2]);
    return std::string(text);
  };
  const uint32_t middle = image->height / 2;
  EXPECT_EQ(hexadecimal(image->at(0, middle)), outlines[0]["colour"].get<std::string>());
  EXPECT_EQ(hexadecimal(image->at(image->width - 1, middle)), outlines[1]["colour"].get<std::string>());
  EXPECT_NE(hexadecimal(image->at(image->width / 4, middle)), outlines[0]["colour"].get<std::string>())
      << "ground inside";
  expectRefusal("info", {folder_ / "scene.fls", "--map", folder_ / "map.jpg"}, {"map.jpg", ".png"});
}

}  // namespace
}  // namespace foreland::test
