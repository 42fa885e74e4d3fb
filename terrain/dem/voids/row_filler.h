// Fills the voids of a grid whose rows are read one after the other, in memory for a few rows and the runs of voids:
// the levels of the pyramid (voids.h) are where its owner keeps them. One thread.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "base/result.h"
#include "terrain/dem/voids/push_rows.h"
#include "terrain/dem/voids/void_regions.h"

namespace foreland::terrain {

struct VoidReport {
  uint64_t total = 0;           // samples of the grid
  uint64_t samples = 0;         // voids filled
  uint64_t regions = 0;         // connected regions of voids (4-neighbours); 0 if there were too many to tell apart
  uint64_t largest_region = 0;  // samples of the largest one
  uint64_t flat_regions = 0;    // of these, filled flat
  bool all_void = false;        // there was no data to fill from; heights are unchanged
  std::string note{};           // a sentence for people; empty if there were no voids
};

// What a grid and the pyramid over it are kept in.
class VoidGrid {
 public:
  virtual ~VoidGrid() = default;
  // Row y of the grid. Goes over rows several times, each time from south to north; all of them the first time.
  virtual Status readRow(uint32_t y, std::span<float> out) = 0;
  // Row y with its voids filled, from south to north; rows without voids are left out.
  virtual Status takeRow(uint32_t y, std::span<const float> row, const RunsOfRow& runs) = 0;
  // Keeps values of coarser levels: `at` counts values, and stays below the grid's samples.
  virtual Status put(uint64_t at, std::span<const float> values) = 0;
  virtual Status get(uint64_t at, std::span<float> values) = 0;
};

// How many values of coarser levels a grid has.
uint64_t coarserValues(uint32_t width, uint32_t height);

class RowFiller {
 public:
  struct RowVoids {
    uint32_t runs = 0, samples = 0;
  };

  // Of more runs regions are not told apart, and all are filled smoothly.
  static constexpr size_t kMaxRuns = size_t{1} << 24;

  RowFiller(VoidGrid& grid, uint32_t width, uint32_t height, size_t max_runs = kMaxRuns);

  // Reads all rows. To be called once.
  Status look();
  // After look().
  const VoidReport& report() const { return report_; }
  std::span<const RowVoids> rows() const { return rows_; }
  // After look(), once. There must be voids, and data.
  Status fill();

 private:
  struct Level {
    RowLevel size;
    uint64_t at = 0;  // its first value
    std::vector<bool> has_void{};
    std::vector<float> even{}, row{};  // while it is made
  };

  Status keep(size_t level, uint32_t y, std::span<const float> row, size_t coarsest);
  Status get(size_t level, uint32_t y, std::span<float> out);
  Status makeCoarse();
  Status push(size_t level);
  double leastFlat() const;

  VoidGrid& grid_;
  std::vector<Level> levels_;
  size_t pin_at_;
  std::vector<RowVoids> rows_;
  RegionFinder finder_;
  std::optional<VoidRegions> found_;
  VoidReport report_;
};

}  // namespace foreland::terrain
