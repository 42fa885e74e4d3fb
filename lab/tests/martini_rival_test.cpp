#include "lab/martini/rival.h"

#include "lab/programs/run_program.h"
#include "tests/support/scene.h"

namespace foreland::lab {
namespace {

TEST(MartiniGridSize, IsTheLargestSquareOfPowerOfTwoIntervalsInTheData) {
  const auto size = [](uint32_t x, uint32_t y) { return martiniGridSize({.samples_x = x, .samples_y = y}); };
  EXPECT_EQ(size(4097, 4097), 4097u);
  EXPECT_EQ(size(4096, 5000), 2049u);
  EXPECT_EQ(size(1201, 400), 257u);
  EXPECT_EQ(size(2, 9), 2u);
  EXPECT_EQ(size(16385, 16385), 4097u);
}

TEST(RunMartini, SaysHowToInstallIt) {
  const test::TemporaryFolder empty;
  const auto result = runMartini(*test::makeScene(17, 17, 1), empty.path(), {{.max_error_m = 1}});
  ASSERT_FALSE(result.ok());
  EXPECT_EQ(result.error().code, ErrorCode::kNotFound);
  EXPECT_NE(result.error().message.find("npm ci --prefix " + empty.path().string()), std::string::npos);
}

TEST(RunProgram, ReturnsWhatIsPrinted) {
  const auto text = runProgram({"printf", "%s-%s", "two words", "*"});
  ASSERT_TRUE(text.ok());
  EXPECT_EQ(*text, "two words-*");
}

TEST(RunProgram, TellsAMissingProgramFromOneThatFails) {
  const auto missing = runProgram({"foreland-no-such-program"});
  ASSERT_FALSE(missing.ok());
  EXPECT_EQ(missing.error().code, ErrorCode::kNotFound);
  const auto failing = runProgram({"sh", "-c", "exit 3"});
  ASSERT_FALSE(failing.ok());
  EXPECT_EQ(failing.error().code, ErrorCode::kIo);
  EXPECT_NE(failing.error().message.find("3"), std::string::npos);
}

}  // namespace
}  // namespace foreland::lab
