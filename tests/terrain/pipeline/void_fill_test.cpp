#include "terrain/pipeline/void_fill.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "terrain/dem/voids/voids.h"
#include "terrain/pipeline/make_void_fill.h"
#include "tests/support/files.h"
#include "tests/support/scene.h"
#include "tests/support/seed.h"

namespace foreland::terrain {
namespace {

// Hills with specks, and a part that has none of their samples.
test::FormulaSource holed(uint32_t width, uint32_t height, uint64_t seed) {
  return {width, height, [=, ground = test::hills(seed)](uint32_t x, uint32_t y) {
            const bool is_void =
                Rng(seed + (uint64_t{y} << 32 | x)).below(20) == 0 || (x > width / 2 && y > height / 2);
            return is_void ? std::nan("") : ground(x, y);
          }};
}

std::vector<float> rowsOf(ElevationSource& source, uint32_t first, uint32_t count) {
  std::vector<float> rows(size_t{count} * source.info().width);
  EXPECT_TRUE(source.readRows(first, count, rows).ok());
  return rows;
}

Result<FilledVoids> make(ElevationSource& source, const std::filesystem::path& prefix) {
  return makeVoidFill(source, prefix, [](std::span<const float>) {}, {});
}

TEST(VoidFill, HasTheHeightsThatFillingInMemoryGives) {
  Rng rng(test::randomSeed());
  for (int round = 0; round < 20; ++round) {
    const test::TemporaryFolder folder;
    const auto width = static_cast<uint32_t>(1 + rng.below(300)), height = static_cast<uint32_t>(1 + rng.below(300));
    test::FormulaSource source = holed(width + 1, height, rng.next());
    std::vector<float> whole = rowsOf(source, 0, height);
    const VoidReport report = fillVoids(whole, width + 1, height);
    if (report.samples == 0 || report.all_void) continue;
    uint32_t seen = 0;
    const auto made = makeVoidFill(source, folder / "x.", [&](std::span<const float>) { ++seen; }, {});
    ASSERT_TRUE(made.ok()) << made.error().message;
    EXPECT_EQ(seen, height);
    EXPECT_EQ(made->report.note, report.note);
    EXPECT_EQ(made->report.samples, report.samples);
    FilledSource filled(source, *made->fill);
    const auto first = static_cast<uint32_t>(rng.below(height)),
               count = static_cast<uint32_t>(1 + rng.below(height - first));
    const auto begin = whole.begin() + static_cast<ptrdiff_t>(size_t{first} * (width + 1));
    EXPECT_EQ(rowsOf(filled, first, count),
              (std::vector<float>(begin, begin + static_cast<ptrdiff_t>(size_t{count} * (width + 1)))));
  }
}

TEST(VoidFill, ADamagedFileIsAnErrorOrGivesTheSame) {
  Rng rng(test::randomSeed());
  const test::TemporaryFolder folder;
  test::FormulaSource source = holed(60, 50, 5);
  const auto made = make(source, folder / "x.");
  ASSERT_TRUE(made.ok());
  FilledSource filled(source, *made->fill);
  const std::vector<float> rows = rowsOf(filled, 0, 50);
  const std::vector<char> sound = test::slurp(made->fill->path());
  int refused = 0;
  for (int round = 0; round < 300; ++round) {
    std::vector<char> bytes = sound;
    if (round % 3 == 0)
      bytes.resize(rng.below(bytes.size()));
    else
      bytes[rng.below(bytes.size())] ^= static_cast<char>(1 << rng.below(8));
    test::spit(folder / "damaged", bytes);
    const auto fill = VoidFill::open(folder / "damaged", 60, 50);
    if (!fill) {
      EXPECT_NE(fill.error().message.find("damaged: damaged"), std::string::npos);
      EXPECT_NE(fill.error().message.find("make the plan again"), std::string::npos);
      ++refused;
      continue;
    }
    FilledSource again(source, *fill);
    std::vector<float> out(rows.size());
    const bool is_whole = again.readRows(0, 50, out).ok();
    EXPECT_EQ(is_whole, fill->check().ok());
    if (is_whole) {
      EXPECT_EQ(out, rows);
      EXPECT_EQ(fill->id(), made->fill->id());
    }
  }
  EXPECT_GT(refused, 100);
}

TEST(VoidFill, IsLaidOverTheHeightsThatItWasMadeOfAlone) {
  const test::TemporaryFolder folder;
  test::FormulaSource source = holed(60, 50, 6);
  test::FormulaSource other(60, 50, [&](uint32_t x, uint32_t y) {
    std::vector<float> row(60);
    EXPECT_TRUE(source.readRows(y, 1, row).ok());
    return y == 20 && x == 7 ? 1.0 : double{row[x]};
  });
  const auto made = make(source, folder / "x.");
  ASSERT_TRUE(made.ok());
  FilledSource filled(other, *made->fill);
  std::vector<float> rows(60 * 20);
  EXPECT_TRUE(filled.readRows(0, 20, rows).ok());
  EXPECT_NE(filled.readRows(10, 20, rows).error().message.find("changed"), std::string::npos);
  EXPECT_FALSE(VoidFill::open(made->fill->path(), 61, 50).ok());
  EXPECT_FALSE(VoidFill::open(made->fill->path(), 60, 49).ok());
}

TEST(VoidFill, ASourceThatChangesWhileItIsReadMakesNone) {
  const test::TemporaryFolder folder;
  uint64_t reads = 0;
  // More than is read at once.
  test::FormulaSource source(3000, 400, [&](uint32_t x, uint32_t y) {
    return (x + y) % 70 == 0 ? std::nan("") : x + (++reads > 2'000'000 ? 1.0 : 0.0);
  });
  const auto made = make(source, folder / "x.");
  ASSERT_FALSE(made.ok());
  EXPECT_NE(made.error().message.find("changed while it was read"), std::string::npos);
  EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
}

TEST(VoidFill, OneThatIsThereAndWholeIsTaken) {
  const test::TemporaryFolder folder;
  test::FormulaSource source = holed(60, 50, 7);
  const auto path = make(source, folder / "x.")->fill->path();
  const std::vector<char> sound = test::slurp(path);
  const auto before = std::filesystem::last_write_time(path);
  ASSERT_TRUE(make(source, folder / "x.").ok());
  EXPECT_EQ(std::filesystem::last_write_time(path), before);
  test::FormulaSource other = holed(60, 50, 8);
  const auto other_path = make(other, folder / "x.")->fill->path();
  EXPECT_NE(other_path, path);
  test::spit(path, test::slurp(other_path));  // under a name that is not its own
  ASSERT_TRUE(make(source, folder / "x.").ok());
  EXPECT_TRUE(test::slurp(path) == sound);
}

}  // namespace
}  // namespace foreland::terrain
