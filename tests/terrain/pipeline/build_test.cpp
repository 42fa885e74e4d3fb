#include "terrain/pipeline/build.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>

#include "terrain/store/verify.h"
#include "tests/support/scene.h"

namespace foreland::terrain {
namespace {

size_t filesIn(const std::filesystem::path& folder) {
  return static_cast<size_t>(std::distance(std::filesystem::directory_iterator(folder), {}));
}

double nan() { return std::numeric_limits<double>::quiet_NaN(); }

TEST(Build, ReportsWhatItDidAndTheSceneIsSound) {
  const test::TemporaryFolder folder;
  test::FormulaSource source(70, 41, test::hills(1));
  std::vector<std::string> stages;
  const Progress progress{.report = [&](std::string_view stage, double fraction) {
    EXPECT_GE(fraction, 0);
    EXPECT_LE(fraction, 1);
    if (stages.empty() || stages.back() != stage) stages.emplace_back(stage);
  }};
  const auto report = buildScene(source, {folder / "a.fls"}, progress);
  ASSERT_TRUE(report.ok());
  EXPECT_EQ(report->samples, 70u * 41u);
  EXPECT_EQ(report->voids_filled, 0u);
  EXPECT_EQ(report->file_bytes, std::filesystem::file_size(folder / "a.fls"));
  EXPECT_EQ(stages, (std::vector<std::string>{"reading", "filling voids", "relief", "bounding", "writing"}));
  const auto verified = verifyScene(folder / "a.fls");
  ASSERT_TRUE(verified.ok());
  EXPECT_TRUE(verified->sound()) << verified->first_faults.front();
  EXPECT_EQ(verified->nodes, report->nodes);
  EXPECT_EQ(filesIn(folder.path()), 1u);
}

TEST(Build, FillsVoidsAndCountsThem) {
  const test::TemporaryFolder folder;
  test::FormulaSource source(30, 30, [](uint32_t x, uint32_t y) { return x % 7 == 3 && y > 4 ? nan() : 100.0 + x; });
  const auto report = buildScene(source, {folder / "a.fls"});
  ASSERT_TRUE(report.ok());
  EXPECT_EQ(report->voids_filled, 4u * 25u);
  ASSERT_FALSE(report->notes.empty());
  const auto scene = Scene::open(folder / "a.fls");
  EXPECT_EQ((*scene)->origin().voids_filled, 100u);
  EXPECT_GE((*scene)->heightRange().lowest, 1000);
  EXPECT_LE((*scene)->heightRange().highest, 1290);
}

// What is whole in the data stays whole, and not a sample is moved; one sample between the steps forbids it.
TEST(Build, WidensTheQuantumToWhatAllHeightsAreMultiplesOf) {
  const test::TemporaryFolder folder;
  for (const auto& [unit, odd, step] : {std::tuple{1.0, 0.0, 1.0},
                                        {0.5, 0.0, 0.5},
                                        {0.75, 0.0, 0.25},
                                        {1.0, 0.3, 0.1},
                                        {1.0, 0.5, 0.5},
                                        {1.7, 0.0, 0.1}}) {
    test::FormulaSource source(40, 33, [&](uint32_t x, uint32_t y) {
      if (x == 7 && y > 4) return nan();
      return unit * std::floor(300 * std::sin(0.3 * x + 0.2 * y)) + (x == 12 && y == 9 ? odd : 0);
    });
    const auto report = buildScene(source, {.output = folder / "a.fls", .widen_quantum = true});
    ASSERT_TRUE(report.ok());
    EXPECT_EQ(report->height_quantum_m, step) << unit << " " << odd;
    EXPECT_EQ(report->notes.size(), step > 0.1 ? 2u : 1u);
    const auto scene = Scene::open(folder / "a.fls");
    ASSERT_TRUE(scene.ok());
    EXPECT_EQ((*scene)->frame().height_quantum_m, step);
    EXPECT_TRUE(verifyScene(folder / "a.fls")->sound());
    const auto kept = buildScene(source, {.output = folder / "b.fls"});
    EXPECT_EQ(kept->height_quantum_m, 0.1);
    EXPECT_NEAR(report->highest_m, kept->highest_m, unit == 1.7 ? 0.1 : 0.051);
  }
}

TEST(Build, NothingButVoidsIsAnError) {
  const test::TemporaryFolder folder;
  test::FormulaSource source(9, 9, [](uint32_t, uint32_t) { return nan(); });
  const auto report = buildScene(source, {folder / "a.fls"});
  ASSERT_FALSE(report.ok());
  EXPECT_NE(report.error().message.find("formula"), std::string::npos);
  EXPECT_EQ(filesIn(folder.path()), 0u);
}

TEST(Build, RefusesHeightsOfTooManyQuanta) {
  const test::TemporaryFolder folder;
  test::FormulaSource source(9, 9, [](uint32_t x, uint32_t) { return x == 4 ? 3e38 : 0.0; });
  EXPECT_EQ(buildScene(source, {folder / "a.fls"}).error().code, ErrorCode::kLimit);
  EXPECT_EQ(filesIn(folder.path()), 0u);
}

TEST(Build, RefusesRastersAndQuantaThatCannotBe) {
  const test::TemporaryFolder folder;
  test::FormulaSource line(1, 9, test::hills(1)), fine(9, 9, test::hills(1));
  EXPECT_FALSE(buildScene(line, {folder / "a.fls"}).ok());
  for (double step : {0.0, -1.0, nan(), HUGE_VAL}) EXPECT_FALSE(buildScene(fine, {folder / "a.fls", step}).ok());
}

TEST(Build, ReplacesASceneWhole) {
  const test::TemporaryFolder folder;
  test::FormulaSource first(9, 9, test::hills(1)), second(17, 9, test::hills(2));
  const auto before = buildScene(first, {folder / "a.fls"});
  const auto open = Scene::open(folder / "a.fls");
  const auto after = buildScene(second, {folder / "a.fls"});
  ASSERT_TRUE(before.ok() && after.ok());
  EXPECT_EQ((*open)->id(), before->scene_id);  // who holds the old one keeps it
  EXPECT_EQ((*Scene::open(folder / "a.fls"))->id(), after->scene_id);
  EXPECT_EQ(filesIn(folder.path()), 1u);
}

TEST(Build, WritesOnlyWhereAFileCanBe) {
  const test::TemporaryFolder folder;
  test::FormulaSource source(9, 9, test::hills(1));
  for (const auto& bad :
       {folder.path(), folder / "missing/a.fls", std::filesystem::path("/dev/full"), std::filesystem::path("")}) {
    const auto report = buildScene(source, {bad});
    ASSERT_FALSE(report.ok()) << bad;
    EXPECT_NE(report.error().message.find(bad.string()), std::string::npos);
  }
  EXPECT_EQ(filesIn(folder.path()), 0u);
  EXPECT_TRUE(std::filesystem::is_character_file("/dev/full"));
}

TEST(Build, WithoutSpaceLeavesNothingBehind) {
  const test::TemporaryFolder folder;
  test::FormulaSource source(200, 200, test::hills(1));
  rlimit before{};
  ASSERT_EQ(::getrlimit(RLIMIT_FSIZE, &before), 0);
  const rlimit small{64 * 1024, before.rlim_max};
  ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &small), 0);
  const auto report = buildScene(source, {folder / "a.fls"});
  ::setrlimit(RLIMIT_FSIZE, &before);
  ASSERT_FALSE(report.ok());
  EXPECT_EQ(report.error().code, ErrorCode::kIo);
  EXPECT_NE(report.error().message.find("MiB"), std::string::npos);
  EXPECT_EQ(filesIn(folder.path()), 0u);
}

TEST(Build, StoppedAtAnyMomentLeavesNothingBehind) {
  const test::TemporaryFolder folder;
  test::FormulaSource source(40, 40, test::hills(1));
  for (int questions = 0; questions < 1000; ++questions) {
    int left = questions;
    const auto report = buildScene(source, {folder / "a.fls", 0.1, 1}, {.keepGoing = [&] { return left-- > 0; }});
    if (report.ok()) {
      EXPECT_GT(questions, 5);
      return;
    }
    ASSERT_EQ(filesIn(folder.path()), 0u);
  }
  FAIL() << "never finished";
}

// As by kill -9: no handler runs.
TEST(Build, KilledLeavesNothingBehind) {
  const test::TemporaryFolder folder;
  const int probe = ::open(folder.path().c_str(), O_TMPFILE | O_RDWR, 0600);
  if (probe < 0) GTEST_SKIP() << "the file system of " << folder.path() << " has no unnamed files";
  ::close(probe);
  test::FormulaSource source(70, 70, test::hills(1));
  const pid_t child = ::fork();
  if (child == 0) {
    const Progress killer{.report = [](std::string_view stage, double) {
      if (stage == "writing") ::kill(::getpid(), SIGKILL);
    }};
    (void)buildScene(source, {folder / "a.fls", 0.1, 1}, killer);
    ::_exit(0);
  }
  int status = 0;
  ASSERT_EQ(::waitpid(child, &status, 0), child);
  EXPECT_TRUE(WIFSIGNALED(status));
  EXPECT_EQ(filesIn(folder.path()), 0u);
}

TEST(Build, PassesTheSourcesErrorOn) {
  struct Broken : test::FormulaSource {
    Broken() : FormulaSource(9, 9, test::hills(1)) {}
    Status readRows(uint32_t, uint32_t, std::span<float>) override {
      return Error{ErrorCode::kIo, "tile 7 cannot be read"};
    }
  } source;
  const test::TemporaryFolder folder;
  EXPECT_EQ(buildScene(source, {folder / "a.fls"}).error().message, "tile 7 cannot be read");
  EXPECT_EQ(filesIn(folder.path()), 0u);
}

}  // namespace
}  // namespace foreland::terrain
