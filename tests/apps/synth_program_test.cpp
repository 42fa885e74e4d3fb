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
  expectRefusal("synth", {"-o", file, "--spacing", "nan"}, {"--spacing", "nan"});
  expectRefusal("synth", {"-o", file, "--spacing", "inf"}, {"--spacing", "inf"});
  expectRefusal("synth", {"-o", file, "--spacing", "0"}, {"spacing"});
  expectRefusal("synth", {"-o", folder / "land.png"}, {"land.png", ".exr or .tif"});
  expectRefusal("synth", {"-o", folder / "nowhere/land.tif"}, {"nowhere/land.tif"});
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
