// What a page is told of the sea: every undulation comes back to half a step, by a reader written from
// docs/PROTOCOL.md.
#include "server/net/http/sea_file.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <vector>

#include "base/rng.h"
#include "tests/support/seed.h"

namespace foreland::server {
namespace {

template <class T>
T at(const std::string& file, size_t offset) {
  T value;
  std::memcpy(&value, file.data() + offset, sizeof(T));
  return value;
}

struct Read {
  uint32_t has_sea, columns, rows;
  double max_error_m;
  std::vector<double> metres;
  size_t end;
};

Read read(const std::string& file) {
  Read out{at<uint32_t>(file, 0), at<uint32_t>(file, 4), at<uint32_t>(file, 8), at<double>(file, 56), {}, 64};
  const double unit_m = at<double>(file, 48);
  std::vector<int64_t> values(size_t{out.columns} * out.rows);
  for (size_t i = 0; i < values.size(); ++i) {
    uint64_t code = 0;
    for (int shift = 0;; shift += 7) {
      const auto byte = static_cast<uint8_t>(file.at(out.end++));
      code |= uint64_t{byte & 127u} << shift;
      if (byte < 128) break;
    }
    const size_t column = i % out.columns;
    const auto value = [&](bool is_there, size_t back) { return is_there ? values[i - back] : 0; };
    const bool has_west = column > 0, has_south = i >= out.columns;
    values[i] = value(has_west, 1) + value(has_south, out.columns) - value(has_west && has_south, out.columns + 1) +
                (code % 2 == 0 ? static_cast<int64_t>(code / 2) : -static_cast<int64_t>(code / 2) - 1);
    out.metres.push_back(static_cast<double>(values[i]) * unit_m);
  }
  return out;
}

proto::UndulationGrid anyGrid(Rng& rng, uint32_t columns, uint32_t rows) {
  proto::UndulationGrid grid{{-180, -90}, {360.0 / (columns - 1), 180.0 / (rows - 1)}, columns, rows, {}, 0.002};
  for (uint32_t i = 0; i < columns * rows; ++i)
    grid.metres.push_back(static_cast<float>(rng.uniform(-1, 1) * std::pow(10, rng.uniform(-3, 4))));
  return grid;
}

TEST(SeaFile, EveryUndulationComesBackToHalfAStep) {
  Rng rng(test::randomSeed());
  for (int i = 0; i < 20; ++i) {
    const auto grid = anyGrid(rng, 2 + static_cast<uint32_t>(rng.below(300)), 2 + static_cast<uint32_t>(rng.below(40)));
    const std::string file = seaFile(true, grid);
    const Read got = read(file);
    EXPECT_EQ(got.has_sea, 1u);
    EXPECT_EQ(got.end, file.size());
    EXPECT_EQ(at<double>(file, 16), grid.first.x);
    EXPECT_EQ(at<double>(file, 24), grid.first.y);
    EXPECT_EQ(at<double>(file, 32), grid.step.x);
    EXPECT_EQ(at<double>(file, 40), grid.step.y);
    EXPECT_GE(got.max_error_m, grid.max_error_m + 0.5 * kSeaStep_m);
    ASSERT_EQ(got.metres.size(), grid.metres.size());
    for (size_t k = 0; k < got.metres.size(); ++k)
      ASSERT_NEAR(got.metres[k], grid.metres[k], 0.5 * kSeaStep_m + 1e-9) << k;
  }
}

TEST(SeaFile, OfASceneWithoutASeaUndulationsAreThinnedAndSayByHowMuch) {
  Rng rng(test::randomSeed());
  const auto grid = anyGrid(rng, 721, 361);
  const Read got = read(seaFile(false, grid));
  EXPECT_EQ(got.has_sea, 0u);
  EXPECT_LE(got.columns, 181u);
  EXPECT_GE(got.max_error_m, proto::thinned(grid, 181).max_error_m + 0.5 * kSeaStep_m);
}

TEST(SeaFile, WithoutAGeoidThereAreNoValues) {
  for (const bool has_sea : {false, true}) {
    const std::string file = seaFile(has_sea, {});
    EXPECT_EQ(file.size(), 64u);
    EXPECT_EQ(read(file).has_sea, uint32_t{has_sea});
    EXPECT_EQ(read(file).columns, 0u);
  }
}

}  // namespace
}  // namespace foreland::server
