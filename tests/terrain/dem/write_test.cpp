// What the writer writes, the reader reads back; nothing half-written stays.
#include "terrain/dem/write.h"

#include <gtest/gtest.h>

#include <sys/resource.h>

#include <algorithm>
#include <csignal>
#include <iterator>

#include "base/rng.h"
#include "tests/terrain/dem/dem_files.h"

namespace foreland::terrain {
namespace {

using DemWrite = DemFiles;

// Rows from the north; the value is 100 * row + column.
std::vector<float> rowsOf(uint32_t width, uint32_t height) {
  std::vector<float> rows;
  for (uint32_t r = 0; r < height; ++r)
    for (uint32_t c = 0; c < width; ++c) rows.push_back(100.0f * static_cast<float>(r) + static_cast<float>(c) + 0.25f);
  return rows;
}

void writeFile(const std::filesystem::path& path, uint32_t width, uint32_t height, double spacing_m) {
  auto writer = createElevationFile({path, width, height, spacing_m});
  ASSERT_TRUE(writer.ok()) << writer.error().message;
  const std::vector<float> rows = rowsOf(width, height);
  for (uint32_t r = 0; r < height; ++r)
    ASSERT_TRUE((*writer)->writeRows(1, std::span(rows).subspan(size_t{r} * width, width)).ok());
  const Status done = (*writer)->finish();
  ASSERT_TRUE(done.ok()) << done.error().message;
}

size_t filesIn(const std::filesystem::path& folder) {
  return static_cast<size_t>(
      std::distance(std::filesystem::directory_iterator(folder), std::filesystem::directory_iterator()));
}

TEST_F(DemWrite, HeightsAndSpacingComeBackFromEveryFormat) {
  for (const char* name : {"land.exr", "land.tif"}) {
    writeFile(folder_ / name, 7, 5, 12.5);
    auto source = open(folder_ / name);
    ASSERT_TRUE(source.ok()) << source.error().message;
    EXPECT_NEAR((*source)->info().frame.axis_x_m.x, 12.5, 1e-12) << name;
    EXPECT_NEAR((*source)->info().frame.axis_y_m.y, 12.5, 1e-12) << name;
    const std::vector<float> heights = readAll(**source), rows = rowsOf(7, 5);
    for (size_t y = 0; y < 5; ++y)
      EXPECT_TRUE(std::equal(heights.begin() + y * 7, heights.begin() + y * 7 + 7, rows.begin() + (4 - y) * 7)) << name;
  }
  EXPECT_EQ(filesIn(folder_), 2u);
}

TEST_F(DemWrite, TheUsersSpacingOverridesTheFiles) {
  writeFile(folder_ / "land.exr", 7, 5, 12.5);
  auto source = open(folder_ / "land.exr", {.spacing_m = 3});
  ASSERT_TRUE(source.ok());
  EXPECT_EQ((*source)->info().frame.axis_x_m.x, 3);
}

TEST_F(DemWrite, AChannelThatIsNotThereIsRefusedWithTheOnesThatAre) {
  writeFile(folder_ / "land.exr", 7, 5, 12.5);
  expectRefusal(open(folder_ / "land.exr", {.channel = "Q"}), "land.exr", "--channel: height");
}

TEST_F(DemWrite, FilesCutShortAreFoundOut) {
  for (const char* name : {"land.exr", "land.tif"}) {
    writeFile(folder_ / name, 300, 300, 10);
    std::filesystem::resize_file(folder_ / name, std::filesystem::file_size(folder_ / name) * 2 / 3);
    EXPECT_FALSE(open(folder_ / name).ok()) << name;
  }
}

TEST_F(DemWrite, AnUnfinishedFileLeavesNothing) {
  for (const char* name : {"land.exr", "land.tif"}) {
    auto writer = createElevationFile({folder_ / name, 7, 5, 10});
    ASSERT_TRUE(writer.ok());
    const std::vector<float> row(7, 1.0f);
    ASSERT_TRUE((*writer)->writeRows(1, row).ok());
  }
  EXPECT_EQ(filesIn(folder_), 0u);
}

// Stands in for a full disk: no file of this process may grow past 16 kB.
class FileSizeLimit {
 public:
  FileSizeLimit() : handler_(std::signal(SIGXFSZ, SIG_IGN)) {
    getrlimit(RLIMIT_FSIZE, &before_);
    const rlimit small{16384, before_.rlim_max};
    setrlimit(RLIMIT_FSIZE, &small);
  }
  ~FileSizeLimit() {
    setrlimit(RLIMIT_FSIZE, &before_);
    std::signal(SIGXFSZ, handler_);
  }

 private:
  void (*handler_)(int);
  rlimit before_{};
};

TEST_F(DemWrite, AFullDiskIsToldAndLeavesNothing) {
  Rng rng(1);
  std::vector<float> rows(size_t{200} * 200);
  for (float& h : rows) h = static_cast<float>(rng.uniform(0, 4000));
  for (const char* name : {"land.exr", "land.tif"}) {
    const FileSizeLimit full;
    Status status;
    auto writer = createElevationFile({folder_ / name, 200, 200, 10});
    ASSERT_TRUE(writer.ok());
    status = (*writer)->writeRows(200, rows);
    if (status.ok()) status = (*writer)->finish();
    ASSERT_FALSE(status.ok()) << name;
    EXPECT_NE(status.error().message.find("cannot be written"), std::string::npos) << status.error().message;
  }
  EXPECT_EQ(filesIn(folder_), 0u);
}

TEST_F(DemWrite, PlacesThatCannotBeWrittenAreRefused) {
  EXPECT_FALSE(createElevationFile({folder_ / "nowhere" / "a.exr", 4, 4, 1}).ok());
  EXPECT_FALSE(createElevationFile({folder_, 4, 4, 1}).ok());
  EXPECT_FALSE(createElevationFile({folder_ / "a.jpg", 4, 4, 1}).ok());
}

}  // namespace
}  // namespace foreland::terrain
