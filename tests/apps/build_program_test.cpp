// `foreland build` as people run it: what comes of good input, and what it says about bad input, bad flags and places
// that cannot be written.
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>

#include "tests/apps/expect_refusal.h"
#include "tests/support/data.h"
#include "tests/support/scene.h"

namespace foreland::test {
namespace {

namespace fs = std::filesystem;

class BuildProgram : public testing::Test {
 protected:
  void SetUp() override {
    fs::create_directory(out());
    std::ofstream grid(input());
    grid << "ncols 70\nnrows 60\nxllcorner 0\nyllcorner 0\ncellsize 10\nNODATA_value -9999\n";
    for (int y = 0; y < 60; ++y)
      for (int x = 0; x < 70; ++x) grid << 500 + 100 * std::sin(0.1 * x) * std::cos(0.13 * y) << (x == 69 ? '\n' : ' ');
  }
  std::string input() const { return folder_ / "hills.asc"; }
  fs::path out() const { return folder_ / "out"; }
  std::string scene() const { return out() / "scene.fls"; }
  // Refused, with nothing left where the scene should have been.
  void expectNothing(const std::vector<std::string>& arguments, const std::vector<std::string>& words,
                     ProgramOptions options = {}) const {
    expectRefusal("build", arguments, words, options);
    EXPECT_EQ(filesIn(out()), 0u);
  }

  TemporaryFolder folder_;
};

TEST_F(BuildProgram, MakesASceneThatIsSound) {
  const ProgramResult built = runProgram("build", {input(), "-o", scene(), "--frame", "planar"});
  EXPECT_EQ(built.exit_code, 0) << built.output;
  EXPECT_NE(built.output.find("70 x 60 samples"), std::string::npos) << built.output;
  EXPECT_EQ(built.output.find('\r'), std::string::npos) << "a bar is for terminals: " << built.output;
  EXPECT_EQ(runProgram("verify", {scene()}).exit_code, 0);
  EXPECT_EQ(filesIn(out()), 1u);
}

TEST_F(BuildProgram, RefusesInputThatIsNone) {
  const std::string empty = folder_ / "empty.tif", noise = folder_ / "noise.tif", missing = folder_ / "missing.tif";
  std::ofstream(empty).flush();
  std::ofstream(noise) << "II*" << std::string(1000, '\x07');
  expectNothing({missing, "-o", scene()}, {missing, "no such file"});
  expectNothing({folder_.path(), "-o", scene()}, {folder_.path(), "directory"});
  for (const std::string& bad : {empty, noise}) expectNothing({bad, "-o", scene()}, {bad});
  expectNothing({input(), missing, "-o", scene()}, {missing});
}

TEST_F(BuildProgram, RefusesFlagsThatItDoesNotKnow) {
  expectNothing({input(), "-o", scene(), "--wings"}, {"--wings", "--help"});
  expectNothing({input(), "-o", scene(), "--spacing", "nan"}, {"--spacing", "nan"});
  expectNothing({input(), "-o", scene(), "--spacing", "-1"}, {"--spacing"});
  expectNothing({input(), "-o", scene(), "--vertical-step", "nan"}, {"--vertical-step"});
  expectNothing({input(), "-o", scene(), "--vertical-step", "0"}, {"--vertical-step"});
  expectNothing({input(), "-o", scene(), "--frame", "round"}, {"--frame", "round", "planar"});
  expectNothing({input()}, {"--output"});
  expectNothing({"-o", scene()}, {"INPUT"});
}

TEST_F(BuildProgram, RefusesPlacesThatCannotBeWritten) {
  const std::string nowhere = folder_ / "nowhere/scene.fls";
  expectNothing({input(), "-o", nowhere}, {nowhere, "no directory"});
  expectNothing({input(), "-o", out()}, {out(), "directory"});
  expectNothing({input(), "-o", "/dev/full"}, {"/dev/full"});
  expectNothing({input(), "-o", input()}, {input(), "one of the inputs"});
  EXPECT_TRUE(fs::is_character_file("/dev/full"));
}

TEST_F(BuildProgram, AFullDiskIsSaidAndLeavesNothing) {
  expectNothing({input(), "-o", scene()}, {scene()}, {.largest_file_bytes = 8192});
  expectNothing({input(), "-o", scene()}, {scene()}, {.largest_file_bytes = 64});
}

TEST_F(BuildProgram, LaysPicturesOverTheTerrain) {
  const std::string picture = folder_ / "picture.pgm";
  std::ofstream(picture, std::ios::binary) << "P5 35 30 255\n" << std::string(35 * 30, 'x');
  const ProgramResult built =
      runProgram("build", {input(), "-o", scene(), "--frame", "planar", "--imagery", picture, "--attribution", "me"});
  EXPECT_EQ(built.exit_code, 0) << built.output;
  EXPECT_NE(built.output.find("picture.pgm: it has no georeference and was laid over"), std::string::npos)
      << built.output;
  const ProgramResult info = runProgram("info", {scene()});
  for (const char* words : {"imagery    35 x 30 texels", "by       me"})
    EXPECT_NE(info.output.find(words), std::string::npos) << info.output;
  EXPECT_EQ(runProgram("verify", {scene()}).exit_code, 0);
}

TEST_F(BuildProgram, RefusesPicturesThatAreNone) {
  const std::string noise = folder_ / "noise.tif", missing = folder_ / "missing.tif";
  std::ofstream(noise) << "II*" << std::string(1000, '\x07');
  expectNothing({input(), "-o", scene(), "--imagery", noise}, {noise, "not a picture"});
  expectNothing({input(), "-o", scene(), "--imagery", missing}, {missing});
  expectNothing({input(), "-o", scene(), "--imagery"}, {"--imagery"});
  expectNothing({input(), "-o", scene(), "--imagery-quality", "50"}, {"--imagery-quality"});
  expectNothing({input(), "-o", scene(), "--attribution", "me"}, {"--attribution"});
  expectNothing({input(), "-o", scene(), "--imagery", noise, "--imagery-quality", "0"}, {"--imagery-quality"});
  expectNothing({input(), "-o", noise, "--imagery", noise}, {noise, "one of the pictures"});
}

TEST_F(BuildProgram, AnotherSceneStaysWhenTheNewOneFails) {
  ASSERT_EQ(runProgram("build", {input(), "-o", scene()}).exit_code, 0);
  const auto bytes = fs::file_size(scene());
  expectRefusal("build", {input(), "-o", scene(), "--vertical-step", "0.01"}, {scene()}, {.largest_file_bytes = 8192});
  EXPECT_EQ(fs::file_size(scene()), bytes);
  EXPECT_EQ(runProgram("verify", {scene()}).exit_code, 0);
}

TEST_F(BuildProgram, OddFilesAreRefusedOrReadWithAWarning) {
  FORELAND_DATA_OR_SKIP(odd, "dem/odd");
  const std::string corrupt = odd / "corrupt.tif", voids = odd / "all-nodata.tif";
  expectNothing({corrupt, "-o", scene()}, {corrupt, "damaged or cut short"});
  expectNothing({voids, "-o", scene()}, {voids, "all 175725 samples are voids", "--nodata"});
  const ProgramResult suffix = runProgram("build", {odd / "us_25m.dem", "-o", scene()});
  EXPECT_EQ(suffix.exit_code, 0);
  EXPECT_NE(suffix.output.find("whatever its suffix .dem says"), std::string::npos) << suffix.output;
  const ProgramResult keys = runProgram("build", {odd / "sba_elev32_wgs84_512.tif", "-o", scene()});
  EXPECT_EQ(keys.exit_code, 0);
  EXPECT_NE(keys.output.find("GeoTIFF tags apparently corrupt"), std::string::npos) << keys.output;
  EXPECT_EQ(filesIn(out()), 1u);
}

}  // namespace
}  // namespace foreland::test
