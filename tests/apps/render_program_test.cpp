// `foreland render` as people run it.
#include <gtest/gtest.h>

#include "terrain/model/png.h"
#include "tests/apps/expect_refusal.h"
#include "tests/support/exr_channel.h"
#include "tests/support/scene.h"

namespace foreland::test {
namespace {

// A scene file of 65 x 65 samples, 10 m apart, whose map begins at (-320, -320).
std::string writeScene(const TemporaryFolder& folder) {
  const std::string path = folder / "land.fls";
  FormulaSource source(65, 65, hills(3));
  CHECK_TRUE(terrain::buildScene(source, {.output = path, .height_quantum_m = 0.1}).ok());
  return path;
}

const std::vector<std::string> kSmall{"--viewport", "64x48"};

std::vector<std::string> with(std::vector<std::string> arguments, const std::vector<std::string>& more = kSmall) {
  arguments.insert(arguments.end(), more.begin(), more.end());
  return arguments;
}

// Of a picture of kSmall's size.
float middleDepth(const std::string& exr) {
  const std::vector<float> depth = readChannel(exr, "depth.Z");
  return depth.size() == 64 * 48 ? depth[24 * 64 + 32] : 0;
}

TEST(RenderProgram, WritesOnePictureInAllFormatsAskedFor) {
  const TemporaryFolder folder;
  const std::string scene = writeScene(folder), png = folder / "a.png", exr = folder / "a.exr";
  const ProgramResult result =
      runProgram("render", with({scene, "--pose", "0,-100,200,10,-20", "-o", png, "-o", exr, "--error", "--tau", "2"}));
  EXPECT_EQ(result.exit_code, 0) << result.output;
  EXPECT_NE(result.output.find("largest error"), std::string::npos) << result.output;
  EXPECT_NE(result.output.find(" 0 of the terrain"), std::string::npos) << result.output;
  EXPECT_EQ(result.output.find("left"), std::string::npos) << "no progress where nobody watches";
  EXPECT_EQ(filesIn(folder.path()), 3u);
  const auto image = terrain::readPng(png);
  ASSERT_TRUE(image.ok());
  EXPECT_EQ(image->width, 64u);
  EXPECT_EQ(image->height, 48u);
}

TEST(RenderProgram, NumbersASequenceAndTellsTheTimeLeft) {
  const TemporaryFolder folder;
  const std::string scene = writeScene(folder), pattern = folder / "frame_%03d.png";
  const ProgramResult result = runProgram("render", with({scene, "--tour", "survey", "--seconds", "1", "--every", "0.5",
                                                          "--section", "--progress", "-o", pattern}));
  EXPECT_EQ(result.exit_code, 0) << result.output;
  EXPECT_NE(result.output.find("3 of 3 pictures, 0:00:00 left"), std::string::npos) << result.output;
  for (const char* name : {"frame_000.png", "frame_001.png", "frame_002.png"})
    EXPECT_TRUE(std::filesystem::exists(folder / name)) << name;
  EXPECT_EQ(filesIn(folder.path()), 4u);
}

// The ground rises by 100 m in a hundred days, under a camera that looks straight down from 300 m above the highest.
TEST(RenderProgram, DrawsTheGroundOfTheDateAskedFor) {
  const TemporaryFolder folder;
  const std::string scene = folder / "land.fls";
  const Time first{}, last{100 * 86'400'000'000};
  FormulaSource source(65, 65, [](uint32_t, uint32_t) { return 0.0; });
  FormulaSource later(65, 65, [](uint32_t, uint32_t) { return 100.0; });
  ASSERT_TRUE(terrain::buildScene(source, {.output = scene,
                                           .height_quantum_m = 0.1,
                                           .epochs = {{first, "first", &source}, {last, "later", &later}}})
                  .ok());
  const auto depthAt = [&](const std::vector<std::string>& options) {
    const std::string exr = folder / "a.exr";
    const ProgramResult result =
        runProgram("render", with(with({scene, "--pose", "0,0,300,0,-90", "-o", exr}), options));
    EXPECT_EQ(result.exit_code, 0) << result.output;
    return middleDepth(exr);
  };
  EXPECT_NEAR(depthAt({}), 400, 0.01);
  EXPECT_NEAR(depthAt({"--section"}), 400, 0.01);
  EXPECT_NEAR(depthAt({"--scene-from", "1970-02-20"}), 350, 0.01);
  EXPECT_NEAR(depthAt({"--scene-from", "1970-02-20", "--section", "--error"}), 350, 0.01);
  EXPECT_NEAR(depthAt({"--scene-from", "2026-01-01"}), 300, 0.01);

  const std::string pattern = folder / "frame_%d.exr";
  const ProgramResult result = runProgram("render", with({scene, "--tour", "survey", "--seconds", "2", "--scene-speed",
                                                          "50d/s", "--error", "-o", pattern}));
  EXPECT_EQ(result.exit_code, 0) << result.output;
  EXPECT_NE(result.output.find("3 pictures"), std::string::npos) << result.output;
  EXPECT_NE(result.output.find("0 of the terrain"), std::string::npos) << result.output;
}

TEST(RenderProgram, RefusesWhatItCannotDoByName) {
  const TemporaryFolder folder;
  const std::string scene = writeScene(folder), png = folder / "a.png";
  const std::vector<std::string> here{"--pose", "0,0,50"};
  expectRefusal("render", {scene}, {"--output"});
  expectRefusal("render", {scene, "-o", png}, {"--pose", "--tour", "--track"});
  expectRefusal("render", with({folder / "none.fls", "-o", png}, here), {"none.fls"});
  expectRefusal("render", with({scene, "-o", folder / "a.tif"}, here), {"a.tif", ".exr or .png"});
  expectRefusal("render", with({scene, "-o", folder / "nowhere/a.png"}, here), {"nowhere"});
  expectRefusal("render", with({scene, "-o", folder / "a_%s.png"}, here), {"a_%s.png", "%"});
  expectRefusal("render", with({scene, "-o", png, "--tau", "0"}, here), {"--tau"});
  expectRefusal("render", with({scene, "-o", png, "--viewport", "9"}, here), {"--viewport", "WIDTHxHEIGHT"});
  expectRefusal("render", with({scene, "-o", png, "--section", "--full"}, here), {"--full"});
  for (const char* pose : {"5", "a,b,c", "1,2", "1,2,3,4,5,6", "1,2,nan", "1,2,3,"})
    expectRefusal("render", {scene, "-o", png, "--pose", pose}, {pose, "LAT,LON,HEIGHT"});
  expectRefusal("render", {scene, "-o", png, "--pose", "400,0,50"}, {"400,0,50", "beyond the data"});
  expectRefusal("render", {scene, "-o", png, "--pose", "0,0,-1"}, {"0,0,-1", "under the ground"});
  expectRefusal("render", {scene, "-o", png, "--pose", "0,0,5,0,91"}, {"PITCH"});
  expectRefusal("render", {scene, "-o", png, "--tour", "survey"}, {"a.png", "%04d"});
  expectRefusal("render", {scene, "-o", folder / "%d.png", "--tour", "loop"}, {"loop", "survey"});
  expectRefusal("render", {scene, "-o", folder / "%d.png", "--track", folder / "none.igc"}, {"none.igc"});
  expectRefusal("render", {scene, "-o", folder / "%d.png", "--tour", "survey", "--every", "0"}, {"--every"});
  expectRefusal("render", with({scene, "-o", png, "--scene-from", "yesterday"}, here), {"yesterday", "YYYY-MM-DD"});
  expectRefusal("render", with({scene, "-o", png, "--scene-from", "2000-01-01"}, here),
                {"land.fls", "does not change in time"});
  expectRefusal("render", with({scene, "-o", png, "--scene-speed", "1d/s"}, here), {"--scene-speed"});
  EXPECT_EQ(filesIn(folder.path()), 1u) << "nothing but the scene";
}

TEST(RenderProgram, AFullDiskIsSaidAndLeavesNothing) {
  const TemporaryFolder folder;
  const std::string scene = writeScene(folder);
  for (const std::string file : {folder / "a.png", folder / "a.exr"})
    expectRefusal("render", with({scene, "--pose", "0,0,50", "-o", file}), {file, "MiB"}, {.largest_file_bytes = 1024});
  EXPECT_EQ(filesIn(folder.path()), 1u);
}

}  // namespace
}  // namespace foreland::test
