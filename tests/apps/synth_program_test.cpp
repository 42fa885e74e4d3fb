// `foreland synth` as people run it.
#include <gtest/gtest.h>

#include "tests/apps/expect_refusal.h"
#include "tests/support/scene.h"

namespace foreland::test {
namespace {

TEST(SynthProgram, RefusesWhatCannotBeMade) {
  const TemporaryFolder folder;
  const std::string file = folder / "land.tif";
  expectRefusal("synth", {}, {"--output"});
  expectRefusal("synth", {"-o", file, "--wings"}, {"--wings", "--help"});
  expectRefusal("synth", {"-o", file, "--size", "1"}, {"size 1"});
  expectRefusal("synth", {"-o", file, "--size", "-5"}, {"--size"});
  expectRefusal("synth", {"-o", file, "--town", "0"}, {"--town", "4096"});
  expectRefusal("synth", {"-o", file, "--town", "9", "--size", "65"}, {"--town", "--size"});
  expectRefusal("synth", {"-o", file, "--spacing", "nan"}, {"--spacing", "nan"});
  expectRefusal("synth", {"-o", file, "--spacing", "inf"}, {"--spacing", "inf"});
  expectRefusal("synth", {"-o", file, "--spacing", "0"}, {"spacing"});
  expectRefusal("synth", {"-o", folder / "land.png"}, {"land.png", ".exr or .tif"});
  expectRefusal("synth", {"-o", folder / "nowhere/land.tif"}, {"nowhere/land.tif"});
  EXPECT_EQ(filesIn(folder.path()), 0u);
}

TEST(SynthProgram, MakesAPictureThatABuildTakes) {
  const TemporaryFolder folder;
  const std::string land = folder / "land.tif", picture = folder / "picture.tif", scene = folder / "scene.fls";
  const ProgramResult made =
      runProgram("synth", {"-o", land, "--size", "33", "--imagery", picture, "--imagery-detail", "2"});
  ASSERT_EQ(made.exit_code, 0) << made.output;
  EXPECT_NE(made.output.find("66 x 66 texels"), std::string::npos) << made.output;
  ASSERT_EQ(runProgram("synth", {"--imagery", picture, "--over", land, "--imagery-detail", "4"}).exit_code, 0);
  const ProgramResult built = runProgram("build", {land, "-o", scene, "--imagery", picture});
  ASSERT_EQ(built.exit_code, 0) << built.output;
  EXPECT_EQ(built.output.find("note"), std::string::npos) << built.output;
  const ProgramResult info = runProgram("info", {scene});
  EXPECT_NE(info.output.find("imagery    132 x 132 texels"), std::string::npos) << info.output;
}

TEST(SynthProgram, RefusesPicturesThatCannotBeMade) {
  const TemporaryFolder folder;
  const std::string picture = folder / "picture.tif", missing = folder / "missing.tif";
  expectRefusal("synth", {"--imagery", picture, "--over", missing}, {missing, "no such file"});
  expectRefusal("synth", {"--imagery", picture}, {"--output"});
  expectRefusal("synth", {"-o", folder / "a.tif", "--over", missing}, {"--over"});
  expectRefusal("synth", {"--imagery", picture, "--imagery-detail", "0", "--over", missing}, {"--imagery-detail"});
  EXPECT_EQ(filesIn(folder.path()), 0u);
}

TEST(SynthProgram, AFullDiskIsSaidAndLeavesNothing) {
  const TemporaryFolder folder;
  for (const std::string file : {folder / "land.tif", folder / "land.exr"})
    expectRefusal("synth", {"-o", file, "--size", "129"}, {file, "cannot be written"}, {.largest_file_bytes = 8192});
  EXPECT_EQ(filesIn(folder.path()), 0u);
}

}  // namespace
}  // namespace foreland::test
