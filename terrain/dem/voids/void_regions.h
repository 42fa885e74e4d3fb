// Connected regions of voids in a height grid, as runs of samples in rows. Memory is in proportion to the number of
// runs.
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace foreland::terrain {

struct VoidRun {
  uint32_t row = 0;
  uint32_t begin = 0;  // first void sample
  uint32_t end = 0;    // one past the last
  uint32_t region = 0;
};

struct VoidRegion {
  uint64_t samples = 0;
};

struct VoidRegions {
  std::vector<VoidRun> runs;        // by row, then by column
  std::vector<VoidRegion> regions;  // in the order of their first run
  // The region of a void sample; the sample must be void.
  uint32_t regionAt(uint32_t x, uint32_t y) const;
};

// Calls visit(begin, end) for the runs of voids of a row, from west to east.
template <class Visit>
void forEachVoidRun(std::span<const float> row, const Visit& visit) {
  for (uint32_t x = 0; x < row.size();) {
    if (std::isfinite(row[x])) {
      ++x;
      continue;
    }
    uint32_t end = x;
    while (end < row.size() && !std::isfinite(row[end])) ++end;
    visit(x, end);
    x = end;
  }
}

// Finds regions in rows that come one after the other, from row 0 on.
class RegionFinder {
 public:
  explicit RegionFinder(size_t max_runs) : max_runs_(max_runs) {}
  void add(std::span<const float> row);
  // Empty if there are more runs than `max_runs`. To be called once, after the last row.
  std::optional<VoidRegions> finish();

 private:
  size_t max_runs_;
  uint32_t rows_ = 0;
  size_t before_ = 0;  // the first run of the row before
  bool too_many_ = false;
  VoidRegions found_;
  std::vector<uint32_t> parent_;
};

std::optional<VoidRegions> findVoidRegions(std::span<const float> heights, uint32_t width, uint32_t height,
                                           size_t max_runs);

}  // namespace foreland::terrain
