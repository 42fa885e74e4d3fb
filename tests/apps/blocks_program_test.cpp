// `foreland plan`, `block` and `merge` as people run them: the scene that `foreland build` makes, whatever the order of
// jobs, and what they say about input that has changed, other plans and blocks that are damaged.
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <utility>

#include "tests/apps/expect_refusal.h"
#include "tests/support/files.h"
#include "tests/support/program.h"

namespace foreland::test {
namespace {

namespace fs = std::filesystem;

class BlocksProgram : public testing::Test {
 protected:
  static constexpr int kWidth = 1100, kHeight = 530;  // two blocks

  void SetUp() override { writeHills(0); }
  enum class Lake : uint8_t { kNone, kVoid };
  void writeHills(double more, Lake lake = Lake::kNone) const {
    std::ofstream grid(input());
    grid << "ncols " << kWidth << "\nnrows " << kHeight
         << "\nxllcorner 0\nyllcorner 0\ncellsize 10\nNODATA_value -9999\n";
    for (int y = 0; y < kHeight; ++y)
      for (int x = 0; x < kWidth; ++x)
        grid << (lake == Lake::kVoid && std::hypot(x - 900, y - 200) < 60
                     ? -9999
                     : 500 + std::round(100 * std::sin(0.1 * x) * std::cos(0.13 * y)) + (x > 1060 ? more : 0))
             << (x == kWidth - 1 ? '\n' : ' ');
  }
  // What the voids of the plan are filled with; empty if there is no such file.
  std::string voids() const {
    for (const auto& entry : fs::directory_iterator(folder_.path()))
      if (entry.path().extension() == ".voids") return entry.path();
    return {};
  }
  std::string input() const { return folder_ / "hills.asc"; }
  std::string plan() const { return folder_ / "plan.json"; }
  std::string blocks() const { return folder_ / "blocks"; }
  std::string scene() const { return folder_ / "scene.fls"; }
  void succeed(const std::string& name, const std::vector<std::string>& arguments) const {
    const ProgramResult result = runProgram(name, arguments);
    EXPECT_EQ(result.exit_code, 0) << result.output;
  }
  void makePlan() const { succeed("plan", {input(), "--frame", "planar", "-o", plan()}); }

  TemporaryFolder folder_;
};

TEST_F(BlocksProgram, MakeTheSceneThatBuildMakes) {
  makePlan();
  for (const char* number : {"1", "0", "1"}) succeed("block", {plan(), number, "-o", blocks()});
  EXPECT_EQ(filesIn(blocks()), 2u);
  succeed("merge", {plan(), blocks(), "-o", scene()});
  succeed("build", {input(), "--frame", "planar", "-o", folder_ / "whole.fls"});
  succeed("build", {input(), "--frame", "planar", "--memory", "1", "-o", folder_ / "windowed.fls"});
  EXPECT_TRUE(slurp(scene()) == slurp(folder_ / "whole.fls"));
  EXPECT_TRUE(slurp(scene()) == slurp(folder_ / "windowed.fls"));
}

TEST_F(BlocksProgram, AWholeWorldStandsInAFile) {
  makePlan();
  const auto write = [&](std::string_view text) { spit(folder_ / "WORLD.toml", {text.begin(), text.end()}); };
  const std::string world = folder_ / "WORLD.toml";
  write("INPUT = ['" + input() + "']\nframe = 'planar'\n");
  succeed("plan", {"--config", world, "-o", folder_ / "again.json"});
  EXPECT_TRUE(slurp(plan()) == slurp(folder_ / "again.json"));
  succeed("build", {"--config", world, "-o", scene()});
  succeed("build", {input(), "--frame", "planar", "-o", folder_ / "whole.fls"});
  EXPECT_TRUE(slurp(scene()) == slurp(folder_ / "whole.fls"));
  write("INPUT = ['" + input() + "']\nfram = 'planar'\n");
  expectRefusal("plan", {"--config", world, "-o", plan()}, {"fram"});
  write("globe = 'yes'\nINPUT = ['" + input() + "']\n");
  expectRefusal("build", {"--config", world, "-o", scene()}, {"globe", "true or false"});
  write("globe = false\nsea = true\nINPUT = ['" + input() + "']\n");
  expectRefusal("build", {"--config", world, "-o", scene()}, {"--sea", "--globe"});
}

TEST_F(BlocksProgram, AChangedInputNeedsANewPlanAndOnlyItsBlocks) {
  makePlan();
  succeed("block", {plan(), "0", "1", "-o", blocks()});
  writeHills(1);
  expectRefusal("block", {plan(), "1", "-o", folder_ / "others"}, {"hills.asc", "plan.json", "foreland plan"});
  makePlan();
  succeed("block", {plan(), "0", "1", "-o", blocks()});
  EXPECT_EQ(filesIn(blocks()), 3u);  // the western block is as it was
  succeed("merge", {plan(), blocks(), "-o", scene()});
  succeed("build", {input(), "--frame", "planar", "-o", folder_ / "whole.fls"});
  EXPECT_TRUE(slurp(scene()) == slurp(folder_ / "whole.fls"));
}

TEST_F(BlocksProgram, FillVoidsAsBuildDoes) {
  writeHills(0, Lake::kVoid);
  makePlan();
  ASSERT_FALSE(voids().empty());
  EXPECT_EQ(fs::path(voids()).filename().string().find("plan.json."), 0u);
  for (const char* number : {"1", "0"}) succeed("block", {plan(), number, "-o", blocks()});
  EXPECT_EQ(filesIn(blocks()), 2u);
  succeed("merge", {plan(), blocks(), "-o", scene()});
  succeed("build", {input(), "--frame", "planar", "-o", folder_ / "whole.fls"});
  succeed("build", {input(), "--frame", "planar", "--memory", "1", "-o", folder_ / "windowed.fls"});
  EXPECT_TRUE(slurp(scene()) == slurp(folder_ / "whole.fls"));
  EXPECT_TRUE(slurp(scene()) == slurp(folder_ / "windowed.fls"));
  EXPECT_FALSE(fs::exists(folder_ / "windowed.fls.blocks"));
}

TEST_F(BlocksProgram, ABlockNeedsWhatItsVoidsAreFilledWith) {
  writeHills(0, Lake::kVoid);
  makePlan();
  const std::string fill = voids();
  const std::vector<char> sound = slurp(fill);
  std::vector<char> damaged = sound;
  damaged[damaged.size() - 100] ^= 1;
  spit(fill, damaged);
  expectRefusal("block", {plan(), "0", "1", "-o", blocks()}, {fill, "damaged", "foreland plan"});
  fs::rename(fill, folder_ / "away");
  expectRefusal("block", {plan(), "0", "-o", blocks()}, {fill, "No such file", "make the plan again"});
  writeHills(3, Lake::kVoid);
  makePlan();
  fs::copy_file(voids(), folder_ / "another");
  fs::remove(voids());
  writeHills(0, Lake::kVoid);
  makePlan();
  EXPECT_EQ(voids(), fill);
  EXPECT_TRUE(slurp(fill) == sound);
  fs::copy_file(folder_ / "another", fill, fs::copy_options::overwrite_existing);
  expectRefusal("block", {plan(), "0", "-o", blocks()}, {fill, "plan.json", "make the plan again"});
  EXPECT_EQ(filesIn(blocks()), 0u);
  makePlan();  // makes another one its own
  EXPECT_TRUE(slurp(fill) == sound);
  writeHills(3, Lake::kVoid);
  expectRefusal("block", {plan(), "0", "-o", blocks()}, {"hills.asc", "foreland plan"});
  EXPECT_EQ(filesIn(blocks()), 0u);
}

TEST_F(BlocksProgram, NameWhatIsWrongAndTheWayOut) {
  expectRefusal("block", {plan(), "0", "-o", blocks()}, {"plan.json", "foreland plan"});
  makePlan();
  expectRefusal("block", {plan(), "2", "-o", blocks()}, {"block 2", "0 to 1"});
  succeed("block", {plan(), "0", "-o", blocks()});
  expectRefusal("merge", {plan(), blocks(), "-o", scene()}, {"block 1 of the plan is missing", "foreland block"});
  std::vector<char> edited = slurp(plan());
  const std::string text(edited.begin(), edited.end());
  edited[text.rfind("\"id\": \"") + 8] ^= 1;
  spit(folder_ / "edited.json", edited);
  expectRefusal("block", {folder_ / "edited.json", "0", "-o", blocks()}, {"edited.json", "foreland plan"});
  spit(folder_ / "none.json", {'{', '}'});
  expectRefusal("merge", {folder_ / "none.json", blocks(), "-o", scene()}, {"none.json", "no plan"});
  expectRefusal("block", {plan(), "1", "-o", blocks()}, {".block", "MiB"}, {.largest_file_bytes = 8192});
  EXPECT_EQ(filesIn(blocks()), 1u);
  succeed("block", {plan(), "1", "-o", blocks()});
  for (const auto& [bytes, way_out] : {std::pair{64, "make room there"}, std::pair{1 << 20, "the file needs"}})
    expectRefusal("merge", {plan(), blocks(), "-o", scene()}, {scene(), way_out, "MiB"},
                  {.largest_file_bytes = static_cast<uint64_t>(bytes)});
  EXPECT_FALSE(fs::exists(scene()));
}

}  // namespace
}  // namespace foreland::test
