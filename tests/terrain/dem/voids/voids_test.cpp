#include "terrain/dem/voids/voids.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <vector>

#include "base/rng.h"
#include "terrain/elevation_source.h"
#include "tests/support/seed.h"

namespace foreland::terrain {
namespace {

struct Grid {
  uint32_t width, height;
  std::vector<float> heights;
  float& at(uint32_t x, uint32_t y) { return heights[size_t{y} * width + x]; }
  VoidReport fill() { return fillVoids(heights, width, height); }
};

Grid plane(uint32_t width, uint32_t height) {
  Grid grid{width, height, std::vector<float>(size_t{width} * height)};
  for (uint32_t y = 0; y < height; ++y)
    for (uint32_t x = 0; x < width; ++x) grid.at(x, y) = 100.0f + static_cast<float>(x) + 2.0f * static_cast<float>(y);
  return grid;
}

void punch(Grid& grid, uint32_t x0, uint32_t y0, uint32_t x1, uint32_t y1) {
  for (uint32_t y = y0; y < y1; ++y)
    for (uint32_t x = x0; x < x1; ++x) grid.at(x, y) = kVoid;
}

TEST(Voids, DataIsNeverChangedAndNoVoidIsLeftWithinTheRangeOfTheData) {
  Rng rng(test::randomSeed());
  for (int round = 0; round < 30; ++round) {
    Grid grid = plane(static_cast<uint32_t>(1 + rng.below(70)), static_cast<uint32_t>(1 + rng.below(70)));
    grid.at(0, 0) = 100;
    const double share = rng.uniform();
    for (size_t i = 1; i < grid.heights.size(); ++i)
      if (rng.uniform() < share) grid.heights[i] = kVoid;
    const Grid before = grid;
    const VoidReport report = grid.fill();
    uint64_t voids = 0;
    float lowest = 1e9f, highest = -1e9f;
    for (const float h : before.heights)
      if (std::isfinite(h)) {
        lowest = std::min(lowest, h);
        highest = std::max(highest, h);
      }
    for (size_t i = 0; i < grid.heights.size(); ++i) {
      if (std::isfinite(before.heights[i])) {
        ASSERT_EQ(grid.heights[i], before.heights[i]);
        continue;
      }
      ++voids;
      ASSERT_GE(grid.heights[i], lowest - 0.01f);
      ASSERT_LE(grid.heights[i], highest + 0.01f);
    }
    EXPECT_EQ(report.samples, voids);
    EXPECT_EQ(report.note.empty(), voids == 0);
  }
}

TEST(Voids, AHoleInAPlaneBecomesThePlane) {
  Grid grid = plane(200, 150);
  const Grid truth = grid;
  punch(grid, 60, 50, 72, 61);
  const VoidReport report = grid.fill();
  EXPECT_EQ(report.samples, 12u * 11u);
  EXPECT_EQ(report.regions, 1u);
  EXPECT_EQ(report.flat_regions, 0u);
  for (size_t i = 0; i < grid.heights.size(); ++i) EXPECT_NEAR(grid.heights[i], truth.heights[i], 1.5);
}

TEST(Voids, TheFillMeetsItsRimWithoutAStep) {
  Grid grid = plane(200, 150);
  punch(grid, 60, 50, 90, 80);
  grid.fill();
  for (uint32_t y = 50; y < 80; ++y) EXPECT_LT(std::fabs(grid.at(60, y) - grid.at(59, y)), 6.0f);
}

TEST(Voids, AMissingHalfBecomesFlatAndLow) {
  Grid grid = plane(600, 600);
  punch(grid, 300, 0, 600, 600);
  const VoidReport report = grid.fill();
  EXPECT_EQ(report.flat_regions, 1u);
  EXPECT_EQ(report.largest_region, 300u * 600u);
  for (uint32_t y = 0; y < 600; y += 50) EXPECT_NEAR(grid.at(500, y), grid.at(500, 300), 5.0);
  EXPECT_LT(grid.at(500, 300), 399.0f + 2.0f * 120);  // low among the heights 399..1597 of the rim
}

TEST(Voids, RegionsAreCountedByTheirSides) {
  Grid grid = plane(40, 40);
  punch(grid, 2, 2, 5, 5);
  punch(grid, 5, 5, 8, 8);  // touches the first only at a corner
  punch(grid, 20, 20, 30, 21);
  punch(grid, 20, 21, 21, 30);
  punch(grid, 29, 21, 30, 30);  // a U
  EXPECT_EQ(grid.fill().regions, 3u);
}

TEST(Voids, NothingButVoidsIsSaidAndLeftAlone) {
  Grid grid{5, 4, std::vector<float>(20, kVoid)};
  EXPECT_TRUE(grid.fill().all_void);
  EXPECT_TRUE(std::isnan(grid.heights[7]));
}

TEST(Voids, InfinitiesAreVoids) {
  Grid grid = plane(9, 9);
  grid.at(4, 4) = std::numeric_limits<float>::infinity();
  EXPECT_EQ(grid.fill().samples, 1u);
  EXPECT_NEAR(grid.at(4, 4), 112.0f, 1.0f);
}

TEST(Voids, TheSameInputGivesTheSameFill) {
  Grid a = plane(300, 301);
  punch(a, 10, 10, 250, 250);
  Grid b = a;
  a.fill();
  b.fill();
  EXPECT_EQ(a.heights, b.heights);
}

// The algorithm as voids.h tells it, with whole levels and nothing clever.
struct PlainFill {
  struct Level {
    int width, height;
    std::vector<float> values;
    float& at(int x, int y) {
      return values[static_cast<size_t>(y) * static_cast<size_t>(width) + static_cast<size_t>(x)];
    }
  };
  std::vector<Level> levels;
  uint64_t regions = 0, flat_regions = 0, largest = 0;
  std::vector<float> flat;  // of each sample of the grid: what its region is flat at, or not a number

  PlainFill(const Grid& grid, bool tells_regions_apart = true)
      : levels{{static_cast<int>(grid.width), static_cast<int>(grid.height), grid.heights}},
        flat(grid.heights.size(), kVoid) {
    if (tells_regions_apart) findRegions();
    int pin_at = 1;
    while (pin_at < 5 && (std::min(levels[0].width, levels[0].height) >> (pin_at + 1)) >= 16) ++pin_at;
    while (levels.back().width > 1 || levels.back().height > 1) {
      pull();
      if (static_cast<int>(levels.size()) - 1 == pin_at) pin(pin_at);
    }
    for (size_t i = levels.size() - 1; i > 0; --i) push(levels[i], levels[i - 1]);
  }

  // A flood from every void that is in no region yet.
  void findRegions() {
    Level& g = levels[0];
    std::vector<bool> is_known(g.values.size());
    for (size_t first = 0; first < is_known.size(); ++first) {
      if (std::isfinite(g.values[first]) || is_known[first]) continue;
      std::vector<size_t> region{first};
      std::vector<float> rim;
      is_known[first] = true;
      const auto visit = [&](int x, int y) {
        if (x < 0 || y < 0 || x >= g.width || y >= g.height) return;
        const size_t at = static_cast<size_t>(&g.at(x, y) - g.values.data());
        if (std::isfinite(g.values[at])) {
          rim.push_back(g.values[at]);
        } else if (!is_known[at]) {
          is_known[at] = true;
          region.push_back(at);
        }
      };
      for (size_t i = 0; i < region.size(); ++i) {
        const int x = static_cast<int>(region[i] % static_cast<size_t>(g.width)),
                  y = static_cast<int>(region[i] / static_cast<size_t>(g.width));
        visit(x - 1, y), visit(x + 1, y), visit(x, y - 1), visit(x, y + 1);
      }
      ++regions;
      largest = std::max<uint64_t>(largest, region.size());
      if (static_cast<double>(region.size()) < std::max(0.02 * static_cast<double>(g.values.size()), 1024.0)) continue;
      ++flat_regions;
      std::sort(rim.begin(), rim.end());
      for (const size_t at : region) flat[at] = rim[rim.size() / 10];
    }
  }

  void pull() {
    Level& fine = levels.back();
    Level coarse{(fine.width + 1) / 2, (fine.height + 1) / 2, {}};
    for (int y = 0; y < coarse.height; ++y)
      for (int x = 0; x < coarse.width; ++x) {
        float sum = 0;
        int count = 0;
        for (int v = 2 * y; v < std::min(2 * y + 2, fine.height); ++v)
          for (int u = 2 * x; u < std::min(2 * x + 2, fine.width); ++u)
            if (std::isfinite(fine.at(u, v))) sum += fine.at(u, v), ++count;
        coarse.values.push_back(count == 0 ? kVoid : sum / static_cast<float>(count));
      }
    levels.push_back(coarse);
  }

  void pin(int level) {
    Level& l = levels.back();
    for (int y = 0; y < l.height; ++y)
      for (int x = 0; x < l.width; ++x)
        if (!std::isfinite(l.at(x, y)))
          l.at(x, y) = flat[static_cast<size_t>(y << level) * static_cast<size_t>(levels[0].width) +
                            static_cast<size_t>(x << level)];
  }

  static void push(Level& coarse, Level& fine) {
    std::vector<std::pair<int, int>> holes;
    for (int y = 0; y < fine.height; ++y)
      for (int x = 0; x < fine.width; ++x)
        if (!std::isfinite(fine.at(x, y))) holes.emplace_back(x, y);
    for (const auto& [x, y] : holes) {
      const int x1 = x / 2, y1 = y / 2, x2 = std::clamp(x1 + (x % 2 ? 1 : -1), 0, coarse.width - 1),
                y2 = std::clamp(y1 + (y % 2 ? 1 : -1), 0, coarse.height - 1);
      fine.at(x, y) = 0.75f * (0.75f * coarse.at(x1, y1) + 0.25f * coarse.at(x2, y1)) +
                      0.25f * (0.75f * coarse.at(x1, y2) + 0.25f * coarse.at(x2, y2));
    }
    for (int sweep = 0; sweep < 8; ++sweep)
      for (const auto& [x, y] : holes)
        fine.at(x, y) = 0.25f * ((fine.at(std::max(x - 1, 0), y) + fine.at(std::min(x + 1, fine.width - 1), y)) +
                                 (fine.at(x, std::max(y - 1, 0)) + fine.at(x, std::min(y + 1, fine.height - 1))));
  }
};

// Rough ground with voids of one kind: 0 specks, 1 boxes, 2 rows, 3 columns, 4 nearly everything, 5 a large region and
// specks, 6 a comb.
Grid groundWithVoids(Rng& rng, uint32_t width, uint32_t height, uint64_t kind) {
  Grid grid{width, height, std::vector<float>(size_t{width} * height)};
  for (float& h : grid.heights) h = static_cast<float>(rng.uniform(-500, 2000));
  const auto box = [&] {
    const auto x = static_cast<uint32_t>(rng.below(width)), y = static_cast<uint32_t>(rng.below(height));
    punch(grid, x, y, static_cast<uint32_t>(x + 1 + rng.below(width - x)),
          static_cast<uint32_t>(y + 1 + rng.below(height - y)));
  };
  const double share = kind == 4 ? 0.999 : kind == 0 || kind == 5 ? rng.uniform(0, 0.3) : 0;
  for (float& h : grid.heights)
    if (rng.uniform() < share) h = rng.below(9) == 0 ? std::numeric_limits<float>::infinity() : kVoid;
  for (uint64_t i = 0; (kind == 1 || kind == 5) && i < 1 + rng.below(3); ++i) box();
  for (uint64_t i = 0; kind == 2 && i < 1 + rng.below(height); ++i) {
    const auto y = static_cast<uint32_t>(rng.below(height));
    punch(grid, 0, y, width, y + 1);
  }
  for (uint64_t i = 0; kind == 3 && i < 1 + rng.below(width); ++i) {
    const auto x = static_cast<uint32_t>(rng.below(width));
    punch(grid, x, 0, x + 1, height);
  }
  for (uint32_t y = 0; kind == 6 && y < height; ++y) punch(grid, 0, y, y % 2 ? width : 1, y + 1);
  grid.heights[rng.below(grid.heights.size())] = 7;
  return grid;
}

TEST(Voids, RowsGiveWhatWholeLevelsGive) {
  Rng rng(test::randomSeed());
  for (int round = 0; round < 300; ++round) {
    const uint64_t largest = round % 10 == 0 ? 400 : 70;
    const uint64_t kind = rng.below(7);
    auto width = static_cast<uint32_t>(1 + rng.below(largest)), height = static_cast<uint32_t>(1 + rng.below(largest));
    if (round % 7 == 0) (round % 2 == 0 ? width : height) = 1;
    Grid grid = groundWithVoids(rng, width, height, kind);
    PlainFill plain(grid);
    const VoidReport report = grid.fill();
    if (report.samples == 0) continue;
    ASSERT_EQ(report.regions, plain.regions);
    ASSERT_EQ(report.flat_regions, plain.flat_regions);
    ASSERT_EQ(report.largest_region, plain.largest);
    ASSERT_EQ(grid.heights, plain.levels[0].values) << width << " x " << height << ", voids of kind " << kind;
  }
}

// Fills a grid, and holds the filler to how it says that it goes over rows.
class WatchedGrid final : public VoidGrid {
 public:
  explicit WatchedGrid(Grid& grid) : grid_(grid), coarser_(coarserValues(grid.width, grid.height)) {}
  Status readRow(uint32_t y, std::span<float> out) override {
    EXPECT_LT(y, grid_.height);
    if (passes_ == 0 || y < last_read_) ++passes_;
    if (passes_ == 1) { EXPECT_EQ(y, rows_seen_++); }
    last_read_ = y;
    std::copy_n(&grid_.at(0, y), grid_.width, out.begin());
    return {};
  }
  Status takeRow(uint32_t y, std::span<const float> row, const RunsOfRow& runs) override {
    EXPECT_GE(y, next_taken_);
    next_taken_ = y + 1;
    for (const auto& [begin, end] : runs)
      for (uint32_t x = begin; x < end; ++x) {
        EXPECT_FALSE(std::isfinite(grid_.at(x, y)));
        grid_.at(x, y) = row[x];
      }
    return {};
  }
  Status put(uint64_t at, std::span<const float> values) override {
    EXPECT_LE(at + values.size(), coarser_.size());
    std::ranges::copy(values, coarser_.begin() + static_cast<std::ptrdiff_t>(at));
    return {};
  }
  Status get(uint64_t at, std::span<float> values) override {
    std::copy_n(coarser_.begin() + static_cast<std::ptrdiff_t>(at), values.size(), values.begin());
    return {};
  }
  int passes() const { return passes_; }

 private:
  Grid& grid_;
  std::vector<float> coarser_;
  int passes_ = 0;
  uint32_t last_read_ = 0, rows_seen_ = 0, next_taken_ = 0;
};

TEST(Voids, TooManyRunsAreFilledWithoutTellingRegionsApart) {
  Rng rng(test::randomSeed());
  for (const bool tells_apart : {true, false})
    for (uint64_t kind = 0; kind < 7; ++kind) {
      Grid grid = groundWithVoids(rng, 150, 130, kind);
      punch(grid, 100, 60, 150, 130);
      PlainFill plain(grid, tells_apart);
      WatchedGrid rows(grid);
      RowFiller filler(rows, grid.width, grid.height, tells_apart ? RowFiller::kMaxRuns : 20);
      ASSERT_TRUE(filler.look().ok());
      EXPECT_EQ(rows.passes(), 1);
      EXPECT_EQ(filler.report().regions, plain.regions);
      ASSERT_TRUE(filler.fill().ok());
      EXPECT_EQ(rows.passes(), plain.flat_regions > 0 ? 4 : 2);
      EXPECT_EQ(grid.heights, plain.levels[0].values) << "voids of kind " << kind;
    }
}

}  // namespace
}  // namespace foreland::terrain
