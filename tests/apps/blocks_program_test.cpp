// `foreland plan`, `block` and `merge` as people run them: the scene that `foreland build` makes, whatever the order of
// jobs, and what they say about input that has changed, other plans and blocks that are damaged.
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <utility>

#include "tests/apps/expect_refusal.h"
#include "tests/support/files.h"
#include "tests/support/program.h"
#include "tests/support/surface_file.h"

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

  // Of the two blocks of a plan, and of its input by foreland build, at once and by blocks.
  void expectTheSceneThatBuildMakes() {
    EXPECT_EQ(filesIn(blocks()), 2u);
    succeed("merge", {plan(), blocks(), "-o", scene()});
    succeed("build", {input(), "--frame", "planar", "-o", folder_ / "whole.fls"});
    succeed("build", {input(), "--frame", "planar", "--memory", "1", "-o", folder_ / "windowed.fls"});
    EXPECT_TRUE(slurp(scene()) == slurp(folder_ / "whole.fls"));
    EXPECT_TRUE(slurp(scene()) == slurp(folder_ / "windowed.fls"));
  }

  TemporaryFolder folder_;
};

TEST_F(BlocksProgram, MakeTheSceneThatBuildMakes) {
  makePlan();
  for (const char* number : {"1", "0", "1"}) succeed("block", {plan(), number, "-o", blocks()});
  expectTheSceneThatBuildMakes();
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

// A scene with all that there is beside the ground.
class BlocksOfADressedScene : public BlocksProgram {
 protected:
  void SetUp() override {
    BlocksProgram::SetUp();
    writePicture('x');
    writeSphere(model());
  }
  void writePicture(char colour) const {
    std::string texels(55 * 27, '\0');
    for (size_t i = 0; i < texels.size(); ++i) texels[i] = static_cast<char>(i * 37 % 200 + (i == 700 ? colour : 0));
    std::ofstream(picture(), std::ios::binary) << "P5 55 27 255\n" << texels;
  }
  std::string picture() const { return folder_ / "picture.pgm"; }
  std::string model() const { return folder_ / "sphere.fls"; }
  std::vector<std::string> dressed(const std::vector<std::string>& more) const {
    std::vector<std::string> words{input(),
                                   "--frame",
                                   "planar",
                                   "--pages",
                                   "coded",
                                   "--object",
                                   model() + "@5000,2600,3,45",
                                   "--imagery",
                                   picture(),
                                   "--imagery-quality",
                                   "60",
                                   "--attribution",
                                   "me"};
    words.insert(words.end(), more.begin(), more.end());
    return words;
  }
  void planAndBlocks() const {
    succeed("plan", dressed({"-o", plan()}));
    succeed("block", {plan(), "0", "1", "-o", blocks()});
  }
};

TEST_F(BlocksOfADressedScene, GiveTheSceneThatBuildMakes) {
  succeed("build", dressed({"-o", folder_ / "whole.fls"}));
  succeed("build", dressed({"--memory", "1", "-o", folder_ / "windowed.fls"}));
  planAndBlocks();
  const ProgramResult merged = runProgram("merge", {plan(), blocks(), "-o", scene()});
  EXPECT_EQ(merged.exit_code, 0) << merged.output;
  for (const char* said : {"note: picture.pgm: it has no georeference", "imagery: ", "0 voids filled"})
    EXPECT_NE(merged.output.find(said), std::string::npos) << said << " is not in: " << merged.output;
  EXPECT_TRUE(slurp(scene()) == slurp(folder_ / "whole.fls"));
  EXPECT_TRUE(slurp(scene()) == slurp(folder_ / "windowed.fls"));
  const ProgramResult info = runProgram("info", {scene()});
  for (const char* words : {"coded", "imagery    69 x 34 texels", "by       me", "sphere"})
    EXPECT_NE(info.output.find(words), std::string::npos) << words << " is not in: " << info.output;
  EXPECT_EQ(runProgram("verify", {scene()}).exit_code, 0);
}

// Blocks are of elevation alone: they ask for no picture, and have the names that they have without.
TEST_F(BlocksOfADressedScene, HaveTheBlocksOfTheGround) {
  makePlan();
  succeed("block", {plan(), "0", "1", "-o", blocks()});
  succeed("plan", dressed({"-o", plan()}));
  fs::rename(picture(), folder_ / "elsewhere.pgm");
  succeed("block", {plan(), "0", "1", "-o", blocks()});
  EXPECT_EQ(filesIn(blocks()), 2u);
  expectRefusal("merge", {plan(), blocks(), "-o", scene()}, {"picture.pgm"});
  fs::rename(folder_ / "elsewhere.pgm", picture());
  succeed("merge", {plan(), blocks(), "-o", scene()});
}

TEST_F(BlocksOfADressedScene, NeedANewPlanWhenAPictureOrAModelChanges) {
  planAndBlocks();
  writePicture('y');
  expectRefusal("merge", {plan(), blocks(), "-o", scene()}, {"picture.pgm", "plan.json", "make the plan again"});
  EXPECT_FALSE(fs::exists(scene()));
  planAndBlocks();
  EXPECT_EQ(filesIn(blocks()), 2u);
  succeed("merge", {plan(), blocks(), "-o", scene()});
  succeed("build", dressed({"-o", folder_ / "whole.fls"}));
  EXPECT_TRUE(slurp(scene()) == slurp(folder_ / "whole.fls"));
  writeGrowingSphere(model(), Time::seconds(0), Time::seconds(1));
  expectRefusal("merge", {plan(), blocks(), "-o", scene()}, {"sphere.fls", "make the plan again"});
}

TEST_F(BlocksOfADressedScene, StandInAFileForPlanAndBuild) {
  const std::string world = folder_ / "WORLD.toml";
  const auto write = [&](const std::string& more) {
    std::ofstream(world) << "INPUT = ['" << input() << "']\nframe = 'planar'\npages = 'coded'\nobject = ['" << model()
                         << "@5000,2600,3,45']\nimagery = ['" << picture()
                         << "']\nimagery-quality = 60\nattribution = 'me'\n"
                         << more;
  };
  write("");
  succeed("plan", dressed({"-o", folder_ / "again.json"}));
  succeed("plan", {"--config", world, "-o", plan()});
  EXPECT_TRUE(slurp(plan()) == slurp(folder_ / "again.json"));
  write("epoch = ['2000-01-01=" + input() + "']\n");
  succeed("plan", {"--config", world, "-o", plan()});
  succeed("plan", dressed({"--epoch", "2000-01-01=" + input(), "-o", folder_ / "again.json"}));
  EXPECT_TRUE(slurp(plan()) == slurp(folder_ / "again.json"));
  write("epoch = ['2000-13-01=" + input() + "']\n");
  expectRefusal("plan", {"--config", world, "-o", plan()}, {"--epoch 2000-13-01", "YYYY-MM-DD=FILE"});
}

TEST_F(BlocksOfADressedScene, AreRefusedBeforeHoursAreSpent) {
  const auto refused = [&](const std::vector<std::string>& options, const std::vector<std::string>& words) {
    std::vector<std::string> all{input(), "--frame", "planar", "-o", plan()};
    all.insert(all.end(), options.begin(), options.end());
    expectRefusal("plan", all, words);
    EXPECT_FALSE(fs::exists(plan()));
  };
  refused({"--globe"}, {"--globe", "foreland build"});
  refused({"--sea"}, {"--sea", "foreland build"});
  refused({"--threads", "2"}, {"--threads", "foreland merge"});
  refused({"--epoch", "2000-01-01=" + input(), "--epoch-blend", "catmull-rom"}, {"catmull-rom", "foreland build"});
  refused({"--epoch", "2000-01-01=" + input(), "--epoch", "2000-01-01=" + input()}, {"two epochs are of 2000-01-01"});
  refused({"--epoch-blend", "b-spline"}, {"no epochs to blend"});
  refused({"--imagery", input()}, {"hills.asc"});
  refused({"--imagery-quality", "50"}, {"--imagery-quality"});
  refused({"--object", model() + "@1e9,2"}, {"sphere.fls", "beyond the data"});
  refused({"--object", "sphere.fls"}, {"sphere.fls"});
  writeGrowingSphere(model(), Time::seconds(0), Time::seconds(1));
  refused({"--object", model() + "@5000,2600", "--epoch", "2000-01-01=" + input()}, {"sphere.fls", "--epoch"});
  expectRefusal("plan", dressed({"-o", picture()}), {"picture.pgm", "one of the inputs"});
}

// Ground that changes in time, on its own lattice in the east and on a coarser one all over.
class BlocksOfGroundInTime : public BlocksProgram {
 protected:
  void SetUp() override {
    BlocksProgram::SetUp();
    writeSurvey(7);
    std::ofstream grid(coarse());
    grid << "ncols 30\nnrows 15\nxllcorner 20\nyllcorner 30\ncellsize 350\n";
    for (int i = 0; i < 30 * 15; ++i) grid << 510 + i % 7 << ' ';
    writeGrowingSphere(model(), Time::seconds(0), Time::seconds(86'400));
  }
  void writeSurvey(int metres) const {
    std::ofstream grid(survey());
    grid << "ncols 40\nnrows 30\nxllcorner 10600\nyllcorner 1000\ncellsize 10\nNODATA_value -9999\n";
    for (int i = 0; i < 40 * 30; ++i) grid << (i % 11 == 0 ? -9999 : 600 + i % 13 + (i == 600 ? metres : 0)) << ' ';
  }
  std::string survey() const { return folder_ / "survey.asc"; }
  std::string coarse() const { return folder_ / "coarse.asc"; }
  std::string model() const { return folder_ / "growing.fls"; }
  std::vector<std::string> words(const std::vector<std::string>& more) const {
    std::vector<std::string> all{input(), "--frame", "planar"};
    all.insert(all.end(), more.begin(), more.end());
    return all;
  }
  std::vector<std::string> inTime(std::vector<std::string> more, bool has_coarse = true) const {
    more.insert(more.begin(), {"--epoch", "2000-01-01=" + input(), "--epoch", "2004-10-04=" + survey()});
    if (has_coarse) more.insert(more.begin() + 4, {"--epoch", "2005-01-01=" + coarse(), "--epoch-blend", "b-spline"});
    return words(more);
  }
};

TEST_F(BlocksOfGroundInTime, GiveTheSceneThatBuildMakes) {
  succeed("build", inTime({"-o", folder_ / "whole.fls"}));
  succeed("build", inTime({"--memory", "1", "-o", folder_ / "windowed.fls"}));
  succeed("plan", inTime({"-o", plan()}));
  succeed("block", {plan(), "1", "0", "-o", blocks()});
  const ProgramResult merged = runProgram("merge", {plan(), blocks(), "-o", scene()});
  EXPECT_EQ(merged.exit_code, 0) << merged.output;
  EXPECT_NE(merged.output.find("epoch 2004-10-04: 1090 samples changed"), std::string::npos) << merged.output;
  EXPECT_TRUE(slurp(scene()) == slurp(folder_ / "whole.fls"));
  EXPECT_TRUE(slurp(scene()) == slurp(folder_ / "windowed.fls"));
  EXPECT_FALSE(fs::exists(folder_ / "windowed.fls.blocks"));
  EXPECT_EQ(runProgram("verify", {scene()}).exit_code, 0);
}

// Dates of poses are epochs of a scene whose ground does not change: its blocks are those without.
TEST_F(BlocksOfGroundInTime, AreThoseOfStillGroundBelowAModelWithPoses) {
  makePlan();
  succeed("block", {plan(), "0", "1", "-o", blocks()});
  const auto posed = [&](const std::string& output) {
    return words({"--object", model() + "@5000,2600", "-o", folder_ / output});
  };
  succeed("plan", posed("plan.json"));
  succeed("block", {plan(), "0", "1", "-o", blocks()});
  EXPECT_EQ(filesIn(blocks()), 2u);
  succeed("merge", {plan(), blocks(), "-o", scene()});
  succeed("build", posed("whole.fls"));
  EXPECT_TRUE(slurp(scene()) == slurp(folder_ / "whole.fls"));
}

TEST_F(BlocksOfGroundInTime, NameTheEpochThatIsAnotherOrMissing) {
  const auto planned = inTime({"-o", plan()}, false);
  succeed("plan", planned);
  succeed("block", {plan(), "0", "1", "-o", blocks()});
  writeSurvey(8);  // as many bytes
  expectRefusal("block", {plan(), "1", "-o", folder_ / "others"}, {"survey.asc", "plan.json", "foreland plan"});
  succeed("block", {plan(), "0", "-o", folder_ / "others"});  // says nothing of the western block
  succeed("plan", planned);
  succeed("block", {plan(), "0", "1", "-o", blocks()});
  EXPECT_EQ(filesIn(blocks()), 3u);
  succeed("merge", {plan(), blocks(), "-o", scene()});
  succeed("build", inTime({"-o", folder_ / "whole.fls"}, false));
  EXPECT_TRUE(slurp(scene()) == slurp(folder_ / "whole.fls"));
  fs::remove(survey());
  expectRefusal("block", {plan(), "1", "-o", blocks()}, {"survey.asc", "No such file", "make the plan again"});
  fs::remove(scene());
  expectRefusal("merge", {plan(), blocks(), "-o", scene()}, {"survey.asc", "No such file", "make the plan again"});
  EXPECT_FALSE(fs::exists(scene()));
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
  expectTheSceneThatBuildMakes();
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
