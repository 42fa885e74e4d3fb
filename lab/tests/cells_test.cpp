// Finished cells of experiments, kept and found again.
#include "lab/cells.h"

#include <gtest/gtest.h>

#include <atomic>
#include <fstream>

#include "base/rng.h"
#include "tests/support/files.h"
#include "tests/support/seed.h"

namespace foreland::lab {
namespace {

using Json = nlohmann::ordered_json;

CellTables someTables(uint64_t seed) {
  Rng rng(seed);
  return {.row = {{"name", "a, \"b\"\n"}, {"count", rng.next()}, {"share", rng.uniform(-1, 1) / 3}, {"whole", 200.0}},
          .rows = {{"frames.csv", "time_s,error\n0," + std::to_string(rng.below(99)) + "\n1,2\n"}, {"none.csv", ""}}};
}

// Six cells, and how many were computed.
struct Experiment {
  std::atomic<size_t> computed = 0;
  CellWork work() {
    return {.count = 6,
            .asked =
                [](size_t i) {
                  return Json{{"cell", i}, {"seed", 1}};
                },
            .compute =
                [this](size_t i, unsigned) {
                  ++computed;
                  return someTables(i);
                }};
  }
};

std::vector<std::string> filesOf(const test::TemporaryFolder& folder, const std::vector<CellTables>& cells) {
  EXPECT_TRUE(writeCells(folder / "out", {{"experiment", "test"}}, {"cell", "cells"}, cells).ok());
  std::vector<std::string> all;
  for (const char* name : {"results.csv", "results.json", "frames.csv", "none.csv"}) {
    const std::vector<char> bytes = test::slurp(folder / ("out/" + std::string(name)));
    all.emplace_back(bytes.begin(), bytes.end());
  }
  return all;
}

TEST(KeptCells, AreFoundAsTheyWereKept) {
  const uint64_t seed = test::randomSeed();
  const test::TemporaryFolder folder;
  const KeptCells kept(folder / "cells");
  for (uint64_t i = 0; i < 50; ++i) ASSERT_TRUE(kept.keep({{"cell", i}}, someTables(seed + i)).ok());
  for (uint64_t i = 0; i < 50; ++i) {
    const auto found = kept.find({{"cell", i}});
    ASSERT_TRUE(found);
    EXPECT_EQ(found->row, someTables(seed + i).row);
    EXPECT_EQ(found->rows, someTables(seed + i).rows);
  }
  EXPECT_FALSE(kept.find({{"cell", 50}}));
  EXPECT_FALSE(KeptCells().find({{"cell", 1}}));
}

// As after a run that was stopped while it wrote, or a disk that was full.
TEST(KeptCells, AreComputedAgainIfTheyAreDamagedOrMissing) {
  const test::TemporaryFolder folder;
  const KeptCells kept(folder / "cells");
  Experiment experiment;
  const auto whole = runCells(experiment.work(), kept, 2);
  ASSERT_TRUE(whole.ok());
  const auto files = filesOf(folder, *whole);
  std::vector<std::filesystem::path> paths;
  for (const auto& entry : std::filesystem::directory_iterator(folder / "cells")) paths.push_back(entry.path());
  ASSERT_EQ(paths.size(), 6u);
  std::filesystem::remove(paths[0]);
  std::filesystem::resize_file(paths[1], std::filesystem::file_size(paths[1]) / 2);
  std::ofstream(paths[2]) << "{}";
  std::filesystem::copy_file(paths[4], paths[3], std::filesystem::copy_options::overwrite_existing);
  experiment.computed = 0;
  const auto again = runCells(experiment.work(), kept, 2);
  EXPECT_EQ(experiment.computed, 4u);
  EXPECT_EQ(filesOf(folder, *again), files);
}

TEST(KeptCells, SayWhatCannotBeWritten) {
  const test::TemporaryFolder folder;
  std::ofstream(folder / "cells") << "a file where the folder should be";
  Experiment experiment;
  const auto cells = runCells(experiment.work(), KeptCells(folder / "cells"), 1);
  ASSERT_FALSE(cells.ok());
  EXPECT_NE(cells.error().message.find("cells'"), std::string::npos) << cells.error().message;
}

TEST(Cells, AreNumberedInTheTablesThatTheyShare) {
  const test::TemporaryFolder folder;
  const auto files = filesOf(folder, {{{{"a", 1}}, {{"frames.csv", "x,y\n1,2\n3,4\n"}, {"none.csv", ""}}},
                                      {{{"a", 0.5}}, {{"frames.csv", "x,y\n5,6\n"}, {"none.csv", "z\n7\n"}}}});
  EXPECT_EQ(files[0], "a\n1\n0.5\n");
  EXPECT_EQ(files[2], "cell,x,y\n0,1,2\n0,3,4\n1,5,6\n");
  EXPECT_EQ(files[3], "cell,z\n1,7\n");
}

}  // namespace
}  // namespace foreland::lab
