// `foreland info` and `foreland verify` as people run them, on scenes that are sound, cut short, changed, or none.
#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "tests/apps/expect_refusal.h"
#include "tests/support/scene.h"
#include "tests/support/surface_file.h"

namespace foreland::test {
namespace {

namespace fs = std::filesystem;

class ScenePrograms : public testing::Test {
 protected:
  void SetUp() override {
    FormulaSource source(65, 65, hills(1), proto::FrameKind::kGeographic);
    const auto report = terrain::buildScene(source, {scene(), 0.1, 1});
    ASSERT_TRUE(report.ok()) << report.error().message;
  }
  std::string model() const { return folder_ / "sphere.fls"; }
  // The same terrain with the model standing in three places.
  std::string withObjects() const {
    const std::string path = folder_ / "objects.fls";
    FormulaSource source(65, 65, hills(1), proto::FrameKind::kGeographic);
    std::vector<terrain::ObjectRequest> requests;
    for (const double step : {0.01, 0.02, 0.03}) requests.push_back({model(), {46 + step, 8 + step}});
    const auto report = terrain::buildScene(
        source, {.output = path, .height_quantum_m = 0.1, .threads = 1, .additions = {.objects = requests}});
    EXPECT_TRUE(report.ok()) << report.error().message;
    return path;
  }
  std::string scene() const { return folder_ / "scene.fls"; }
  // A copy with one bit of the byte at `share` of its length turned over.
  std::string flipped(double share) const {
    const fs::path copy = folder_ / "flipped.fls";
    fs::copy_file(scene(), copy, fs::copy_options::overwrite_existing);
    flip(copy, share);
    return copy;
  }
  static void flip(const fs::path& path, double share) {
    std::fstream file(path, std::ios::in | std::ios::out | std::ios::binary);
    const auto at = static_cast<std::streamoff>(share * static_cast<double>(fs::file_size(path)));
    file.seekg(at);
    const char byte = static_cast<char>(file.get() ^ 0x10);
    file.seekp(at);
    file.put(byte);
  }

  TemporaryFolder folder_;
};

TEST_F(ScenePrograms, InfoGivesFrameAndSizesAsJson) {
  const ProgramResult result = runProgram("info", {scene(), "--json"}, {.streams = Streams::kOutputOnly});
  ASSERT_EQ(result.exit_code, 0);
  const auto json = nlohmann::json::parse(result.output, nullptr, false);
  ASSERT_FALSE(json.is_discarded()) << result.output;
  EXPECT_EQ(json["title"], "formula");
  EXPECT_EQ(json["samples"], (std::vector<int>{65, 65}));
  EXPECT_EQ(json["frame"]["axes"], (std::vector<std::string>{"east", "north", "up"}));
  EXPECT_NEAR(json["frame"]["origin"]["latitude_deg"], 46.027, 0.001);
  EXPECT_TRUE(json["frame"].contains("crs"));
  ASSERT_EQ(json["tiles"].size(), 1u);
  EXPECT_EQ(json["tiles"][0]["content"], "relief");
  EXPECT_EQ(json["tiles"][0]["texels"], (std::vector<int>{65, 65}));
  EXPECT_GT(json["tiles"][0]["megabytes"], 0);
}

TEST_F(ScenePrograms, InfoPrintsTheSceneForPeople) {
  const ProgramResult result = runProgram("info", {scene()});
  EXPECT_EQ(result.exit_code, 0);
  for (const char* word : {"formula", "65 x 65", "geographic"})
    EXPECT_NE(result.output.find(word), std::string::npos) << word << " is not in: " << result.output;
}

TEST_F(ScenePrograms, VerifySaysWhatItChecked) {
  const ProgramResult result = runProgram("verify", {scene()});
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_NE(result.output.find(scene() + ": sound"), std::string::npos) << result.output;
}

TEST_F(ScenePrograms, TellTheSameOfCodedPages) {
  const std::string raster = folder_ / "land.exr", plain = folder_ / "plain.fls", coded = folder_ / "coded.fls";
  ASSERT_EQ(runProgram("synth", {"-o", raster, "--size", "257"}).exit_code, 0);
  for (const auto& [pages, path] : {std::pair("plain", plain), std::pair("coded", coded)}) {
    const ProgramResult built = runProgram("build", {raster, "-o", path, "--pages", pages});
    ASSERT_EQ(built.exit_code, 0) << built.output;
    EXPECT_EQ(runProgram("verify", {path}).exit_code, 0);
  }
  EXPECT_LT(2 * fs::file_size(coded), fs::file_size(plain));
  const auto about = [&](const std::string& path) {
    const ProgramResult result = runProgram("info", {path, "--json"}, {.streams = Streams::kOutputOnly});
    return nlohmann::json::parse(result.output, nullptr, false);
  };
  auto of_plain = about(plain), of_coded = about(coded);
  EXPECT_LT(of_coded["pages"]["bits_a_sample"].get<double>(), 20);
  for (const char* differs : {"file", "id", "pages"}) of_plain.erase(differs), of_coded.erase(differs);
  EXPECT_EQ(of_plain.dump(), of_coded.dump());
  EXPECT_NE(runProgram("info", {coded}).output.find("bits a sample"), std::string::npos);
  flip(coded, 0.5);
  expectRefusal("verify", {coded}, {coded});
}

TEST_F(ScenePrograms, VerifyFindsAFlippedByteAnywhere) {
  for (const double share : {0.0, 0.001, 0.1, 0.3, 0.5, 0.7, 0.9, 0.999}) {
    const std::string file = flipped(share);
    expectRefusal("verify", {file}, {file});
  }
}

TEST_F(ScenePrograms, InfoTellsTheObjects) {
  writeSphere(model());
  const std::string path = withObjects();
  const ProgramResult result = runProgram("info", {path, "--json"}, {.streams = Streams::kOutputOnly});
  ASSERT_EQ(result.exit_code, 0);
  const auto json = nlohmann::json::parse(result.output, nullptr, false);
  ASSERT_FALSE(json.is_discarded()) << result.output;
  EXPECT_EQ(json["title"], "formula");
  EXPECT_EQ(json["objects"]["count"], 3);
  ASSERT_EQ(json["objects"]["models"].size(), 1u);
  const auto& sphere = json["objects"]["models"][0];
  EXPECT_EQ(sphere["title"], "sphere");
  EXPECT_EQ(sphere["placed"], 3);
  EXPECT_EQ(sphere["base"]["triangles"], 8);
  EXPECT_EQ(sphere["levels"], 3);
  EXPECT_EQ(sphere["full_triangles"], 512);
  const ProgramResult people = runProgram("info", {path});
  EXPECT_EQ(people.exit_code, 0);
  for (const char* words : {"3 of 1 model", "sphere: 3 placed; 8 base triangles, quadrisection, 3 levels, 512"})
    EXPECT_NE(people.output.find(words), std::string::npos) << words << " is not in: " << people.output;
  const ProgramResult without = runProgram("info", {scene(), "--json"}, {.streams = Streams::kOutputOnly});
  EXPECT_EQ(nlohmann::json::parse(without.output, nullptr, false)["objects"]["count"], 0);
}

TEST_F(ScenePrograms, VerifyChecksTheModelsToo) {
  writeSphere(model());
  const std::string path = withObjects();
  const ProgramResult sound = runProgram("verify", {path});
  EXPECT_EQ(sound.exit_code, 0) << sound.output;
  for (const std::string& words : {std::string("3 objects"), std::string("model 0: header"), path + ": sound"})
    EXPECT_NE(sound.output.find(words), std::string::npos) << words << " is not in: " << sound.output;
  // A model that was damaged before the scene was built: the scene's own checksums know nothing of it.
  flip(model(), 0.7);
  withObjects();
  expectRefusal("verify", {path}, {path + ": model 0: block 0", "build or copy"});
}

TEST_F(ScenePrograms, WhatIsNoSceneIsRefused) {
  const std::string empty = folder_ / "empty.fls", cut = folder_ / "cut.fls", text = folder_ / "text.fls";
  std::ofstream(empty).flush();
  std::ofstream(text) << std::string(100'000, 'x');
  fs::copy_file(scene(), cut);
  fs::resize_file(cut, fs::file_size(cut) / 3);
  for (const char* program : {"info", "verify"}) {
    for (const std::string& bad : {empty, cut, text, folder_.path().string(), std::string(folder_ / "missing.fls")})
      expectRefusal(program, {bad}, {bad});
    expectRefusal(program, {scene(), "--wings"}, {"--wings", "--help"});
    expectRefusal(program, {}, {"SCENE"});
  }
}

}  // namespace
}  // namespace foreland::test
